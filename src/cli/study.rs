use super::Failure;
#[derive(clap::Args)]
pub struct StudyArgs {}
pub fn run(_: &StudyArgs) -> Result<(), Failure> {
    Ok(())
}
