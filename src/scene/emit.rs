// SPDX-License-Identifier: MIT OR Apache-2.0
//! From an emitter of a scene to what runs: shaders compiled, numbers checked, the integrator chosen. No GPU is needed.

use super::{
    colliding::meets,
    kindled::KindledPlan,
    particles::{Draw, EffectScene, EmitterScene, LawScene, Throws},
    Attractor, PlannedBuffer, Scene, SceneError, VolumePlan,
};
use crate::{
    ballistic::{self, Blend},
    draw::sprites::Splats,
    gpu::{self, glsl},
    particles::{
        black_hole::{BlackHole, Integrator},
        colliding::Colliding,
        drag::Drag,
        PoolState, Thrown,
    },
    shaders,
};
use glam::Vec3;
use std::{borrow::Cow, fs, path::Path};

/// SPIR-V, of this crate or just compiled.
pub type Spv = Cow<'static, [u8]>;

/// An emitter as it will run.
#[derive(Clone, Debug, PartialEq)]
pub struct EmitterPlan {
    /// As in the scene.
    pub name: String,
    /// What moves its particles, why so, and what error is to be expected.
    pub reason: String,
    /// What it throws.
    pub throws: PlannedThrows,
    /// Most particles at once.
    pub capacity: u32,
    /// How sprites are drawn.
    pub draw: Draw,
    /// The vertex, geometry or compute shader for it.
    pub sprites: Spv,
    /// Sprites fade where they meet the scene.
    pub soft: bool,
    /// On the sprites: width and height (pixels), and four bytes each.
    pub texture: Option<([u32; 2], Vec<u8>)>,
    /// Where it is at the start (m).
    pub at_m: Vec3,
    /// Light on the ground at 1 m, linear.
    pub light: Option<Vec3>,
}

/// What an emitter throws.
#[derive(Clone, Debug, PartialEq)]
pub enum PlannedThrows {
    /// A closed form.
    Effect(ballistic::Effect),
    /// A closed form, thrown by impacts.
    Kindled(Box<KindledPlan>),
    /// A pool with a law.
    Law(Box<LawPlan>),
}

/// A law as it will run.
#[derive(Clone, Debug, PartialEq)]
pub struct LawPlan {
    /// The advance with the law in it.
    pub spv: Spv,
    /// Its specialization constants.
    pub constants: Vec<u32>,
    /// Its numbers.
    pub numbers: Vec<u8>,
    /// Where, how fast and when particles are born.
    pub emitter: crate::particles::Emitter,
    /// Of every particle (s).
    pub life_s: f64,
    /// Step (s).
    pub dt_s: f64,
    /// How particles look.
    pub look: LawScene,
    /// What the colour goes by.
    pub centres: Vec<Attractor>,
}

impl EmitterPlan {
    /// Whether it throws from a place of its own, and not from where impacts are.
    pub fn has_place(&self) -> bool {
        !matches!(self.throws, PlannedThrows::Kindled(_))
    }

    /// Whether it needs a copy of the scene's depth.
    pub fn needs_depth(&self) -> bool {
        self.soft || self.draw == Draw::Splat
    }

    pub(super) fn list_buffers(&self, pixels: u64, list: &mut Vec<PlannedBuffer>) {
        let because = format!("emitter.{}", self.name);
        if let PlannedThrows::Kindled(kindled) = &self.throws {
            kindled.list_buffers(&self.name, list);
        }
        let mut add = |name: &str, bytes: u64, because: String| {
            list.push(PlannedBuffer { name: name.into(), bytes, because });
        };
        if let PlannedThrows::Law(law) = &self.throws {
            let stride = u64::from((self.capacity + 1).next_multiple_of(32));
            for i in 0..2 {
                add(&format!("particles.particles.{i}"), 28 * stride, because.clone());
            }
            add("particles.pool", size_of::<PoolState>() as u64, because.clone());
            add("particles.emitters, births, law", 80 + law.numbers.len() as u64, because.clone());
            let tiles = (2 * u64::from(self.capacity)).div_ceil(512);
            add(
                "particles.places (512 slots a tile)",
                12 * tiles + 16 * tiles.div_ceil(256) + 4,
                because.clone(),
            );
            let listed = if law.look.colliding.is_some() { 40 * stride } else { 4 };
            add("particles.deferred", 16 + listed, because.clone());
            add("particles.glow (of the host)", 304, because.clone());
        }
        if let Some(([w, h], _)) = &self.texture {
            add("draw.texture", 16 + u64::from(w * h) * 16 * 4 / 3, format!("{because}.texture"));
        }
        if self.needs_depth() && !list.iter().any(|it| it.name == "draw.scene_depth") {
            let why = format!("{because}.{}", if self.soft { "soft" } else { "draw = \"splat\"" });
            list.push(PlannedBuffer {
                name: "draw.depth.copied".into(),
                bytes: 4 * pixels,
                because: why.clone(),
            });
            list.push(PlannedBuffer { name: "draw.scene_depth".into(), bytes: 4 * pixels, because: why });
        }
        if self.draw == Draw::Splat && !list.iter().any(|it| it.name == "draw.splats") {
            let bytes = Splats::BYTES_A_PIXEL * pixels;
            list.push(PlannedBuffer {
                name: "draw.splats".into(),
                bytes,
                because: format!("{because}.draw"),
            });
        }
    }

    /// Passes before those of the picture, `often` those that follow a step of the volume.
    pub(super) fn list_steps(&self, (fps, often): (f64, f64), list: &mut Vec<(String, f64)>) {
        if let PlannedThrows::Kindled(kindled) = &self.throws {
            kindled.list_steps(&self.name, often, list);
        }
        if let PlannedThrows::Law(law) = &self.throws {
            let steps = 1.0 / (fps * law.dt_s);
            list.push((
                format!("particles.prepare, particles.{} ({})", law_name(&law.look.file), self.name),
                steps,
            ));
        }
    }
}

/// Passes of the picture that particles add.
pub(super) fn list_draws(emitters: &[EmitterPlan], list: &mut Vec<(String, f64)>) {
    let names = |wanted: &dyn Fn(&EmitterPlan) -> bool| {
        emitters.iter().filter(|it| wanted(it)).map(|it| it.name.as_str()).collect::<Vec<_>>().join(", ")
    };
    if emitters.iter().any(EmitterPlan::needs_depth) {
        list.push(("draw.depth (copied for soft or splatted sprites)".into(), 1.0));
    }
    let quads = names(&|it| matches!(it.draw, Draw::Quads | Draw::Geometry));
    let splats = names(&|it| it.draw == Draw::Splat);
    if !quads.is_empty() {
        list.push((format!("draw.sprites ({quads})"), 1.0));
    }
    if !splats.is_empty() {
        list.push((format!("draw.splat ({splats}), draw.splat_over"), 1.0));
    }
}

fn law_name(file: &str) -> &str {
    if file.ends_with(".glsl") {
        "user"
    } else {
        file
    }
}

impl Scene {
    pub(super) fn plan_emitters(&self, volume: Option<&VolumePlan>) -> Result<Vec<EmitterPlan>, SceneError> {
        self.emitters.iter().map(|emitter| self.plan_emitter(emitter, volume)).collect()
    }

    fn plan_emitter(
        &self,
        emitter: &EmitterScene,
        volume: Option<&VolumePlan>,
    ) -> Result<EmitterPlan, SceneError> {
        let texture = emitter.texture.as_deref().map(|file| self.load_texture(file)).transpose()?;
        let (throws, reason, sprites, capacity) = match &emitter.throws {
            Throws::Effect(scene @ EffectScene { kindled: Some(kindled), .. }) => {
                let (effect, sprites) = self.effect(emitter, scene)?;
                let plan = KindledPlan::new(kindled, emitter.changed(scene, effect));
                let (reason, most) = (plan.reason(kindled), plan.most_particles());
                (PlannedThrows::Kindled(Box::new(plan)), reason, sprites, most)
            }
            Throws::Effect(scene) => {
                let (effect, sprites) = self.effect(emitter, scene)?;
                let effect = emitter.changed(scene, effect);
                effect.check().map_err(|reason| SceneError::Shader { file: scene.file.clone(), reason })?;
                let most = effect.most_particles();
                let reason = format!(
                    "`{}` in closed form: {most} particles at the most, none of them stored, exact at any time step; {}",
                    effect.name,
                    match effect.blend {
                        Blend::Add => "light adds up in any order",
                        Blend::Over => "laid over one another, oldest first",
                    }
                );
                (PlannedThrows::Effect(effect), reason, sprites, most as u32)
            }
            Throws::Law(law) => {
                let (plan, reason) = self.law(emitter, law, volume)?;
                let sprites: Spv = match emitter.draw {
                    Draw::Quads => shaders::PARTICLES_GLOW_VERT.into(),
                    Draw::Geometry => shaders::PARTICLES_GLOW_GEOM.into(),
                    Draw::Splat => shaders::PARTICLES_GLOW_SPLAT_COMP.into(),
                    Draw::Balls => shaders::PARTICLES_BALLS_VERT.into(),
                };
                let wanted = law.wanted(emitter);
                let capacity = law.capacity.map_or(wanted, u64::from);
                let reason = if capacity < wanted {
                    format!(
                        "{reason}; room for {capacity} of about {wanted}: the rest is dropped and counted"
                    )
                } else {
                    reason
                };
                (PlannedThrows::Law(Box::new(plan)), reason, sprites, capacity as u32)
            }
        };
        let at_m = match &throws {
            PlannedThrows::Effect(effect) => effect.emitter.at_m,
            PlannedThrows::Kindled(_) => Vec3::ZERO,
            PlannedThrows::Law(law) => law.emitter.at_m,
        };
        Ok(EmitterPlan {
            at_m,
            name: emitter.name.clone(),
            reason,
            throws,
            capacity,
            draw: emitter.draw,
            sprites,
            soft: emitter.soft,
            texture,
            light: emitter.light.map(Vec3::from),
        })
    }

    fn read_glsl(&self, file: &str) -> Result<String, SceneError> {
        let path = self.base_dir.as_deref().unwrap_or(Path::new("")).join(file);
        fs::read_to_string(&path)
            .map_err(|source| SceneError::Read { path: path.display().to_string(), source })
    }

    /// Numbers of an effect, and the shader that draws it so.
    fn effect(
        &self,
        emitter: &EmitterScene,
        scene: &EffectScene,
    ) -> Result<(ballistic::Effect, Spv), SceneError> {
        let (file, draw, is_kindled) = (scene.file.as_str(), emitter.draw, scene.kindled.is_some());
        let shader = |reason| SceneError::Shader { file: file.to_owned(), reason };
        let (effect, text) = match ballistic::Builtin::named(file) {
            Some(builtin) => {
                let name = format!("ballistic.{file}{}.vert", if is_kindled { "_kindled" } else { "" });
                let made = shaders::ALL.iter().find(|(known, _)| *known == name && draw == Draw::Quads);
                if let Some((_, spv)) = made {
                    return Ok((builtin.effect(), (*spv).into()));
                }
                (builtin.effect(), builtin.file().1.to_owned())
            }
            None => {
                let text = self.read_glsl(file)?;
                let effect = ballistic::Effect::parse(file, &text)
                    .map_err(|bad| shader(bad.to_string().replacen(&format!("{file}:"), "", 1)))?;
                (effect, text)
            }
        };
        let defines = match (is_kindled, effect.has_ground) {
            (false, false) => "",
            (false, true) => "#define GROUND_BINDING 8\n",
            (true, false) => "#define KINDLED_BINDING 8\n",
            (true, true) => "#define KINDLED_BINDING 8\n#define GROUND_BINDING 10\n",
        };
        let has_ground = self.terrain.is_some() || !self.water.is_empty();
        if effect.has_ground && !has_ground {
            let reason = format!(
                "ends on the ground (`ground = 1`), and emitter `{}` has none: [terrain] or [[water]]",
                emitter.name
            );
            return Err(shader(reason));
        }
        let (stage, after) = match draw {
            Draw::Quads => (glsl::Stage::Vertex, "draw/sprites_vert.glsl"),
            Draw::Geometry => (glsl::Stage::Geometry, "draw/sprites_geom.glsl"),
            Draw::Splat | Draw::Balls => (glsl::Stage::Compute, "draw/sprites_splat.glsl"),
        };
        let before = [defines, "#include \"draw/view.glsl\"\n#include \"draw/sprite.glsl\"\n#include \"ballistic/effect.glsl\"\n"].concat();
        let after = format!("#include \"ballistic/sprite.glsl\"\n#include \"{after}\"\n");
        Ok((effect, compile(file, &before, &text, &after, stage)?.into()))
    }

    /// What lands of an effect in a file.
    pub(super) fn compile_landing(&self, file: &str) -> Result<Spv, SceneError> {
        let before =
            "#define EFFECT_BINDING 2\n#define GROUND_BINDING 3\n#include \"ballistic/effect.glsl\"\n";
        let after = "#include \"ballistic/land.glsl\"\n";
        Ok(compile(file, before, &self.read_glsl(file)?, after, glsl::Stage::Compute)?.into())
    }

    fn law(
        &self,
        emitter: &EmitterScene,
        law: &LawScene,
        volume: Option<&VolumePlan>,
    ) -> Result<(LawPlan, String), SceneError> {
        let dt_s = volume.filter(|_| law.colliding.is_some()).map_or(self.step_s(law.dt_s), |it| it.dt_s);
        let at_m = Vec3::from(emitter.at_m.unwrap_or_default());
        let (spv, constants, numbers, centres, reason): (Spv, _, _, _, _) = match law.file.as_str() {
            "black_hole" => {
                let (holes, chosen) = self.black_hole(law, at_m, dt_s);
                holes.check().map_err(|invalid| SceneError::Shader {
                    file: format!("emitter.{}", emitter.name),
                    reason: invalid.to_string(),
                })?;
                let spv = shaders::PARTICLES_BLACK_HOLE_COMP.into();
                (spv, holes.constants().to_vec(), holes.numbers().to_vec(), self.attractors.clone(), chosen)
            }
            "colliding" => {
                let scene = law.colliding.as_ref().expect("the law has its numbers");
                let volume = volume.expect("a scene that collides has a volume");
                let colliding = self.colliding(emitter, scene, volume);
                colliding.check().map_err(|invalid| SceneError::Shader {
                    file: format!("emitter.{}", emitter.name),
                    reason: invalid.to_string(),
                })?;
                let kernel = Colliding::law(scene.variant);
                let numbers = bytemuck::bytes_of(&colliding).to_vec();
                let reason = meets(scene, volume);
                (kernel.spv.into(), kernel.constants.to_vec(), numbers, Vec::new(), reason)
            }
            "drag" => {
                let drag = Drag { pull_mps2: law.pull_mps2.into(), drag_per_s: law.drag_per_s };
                let reason = "`drag` in closed form: exact at any step".to_owned();
                (Drag::LAW.spv.into(), Vec::new(), bytemuck::bytes_of(&drag).to_vec(), Vec::new(), reason)
            }
            file => {
                let text = self.read_glsl(file)?;
                let before = "#include \"particles/particle.glsl\"\n";
                let after = "#include \"particles/advance.glsl\"\n";
                let spv = compile(file, before, &text, after, glsl::Stage::Compute)?;
                let numbers = if law.numbers.is_empty() { vec![0.0] } else { law.numbers.clone() };
                let reason = format!("the law in {file}: its error is its author's");
                let centres = self.attractors.clone();
                (spv.into(), Vec::new(), bytemuck::cast_slice(&numbers).to_vec(), centres, reason)
            }
        };
        let plan = LawPlan {
            spv,
            constants,
            numbers,
            emitter: crate::particles::Emitter {
                at_m,
                velocity_mps: Vec3::from(emitter.velocity_mps.unwrap_or_default()),
                speed_mps: law.speed_mps,
                rate_per_s: emitter.rate_per_s.unwrap_or(0.0),
                thrown: if law.corners { Thrown::Corners } else { Thrown::Singly },
            },
            life_s: emitter.life_s.unwrap_or(1.0),
            dt_s,
            look: law.clone(),
            centres,
        };
        Ok((plan, format!("{reason}; step {dt_s:.6} s")))
    }

    /// The holes, and the cheapest integrator whose expected error is within the tolerance: the closed form where there is
    /// one, else leapfrog or RK4 by the leading terms of their errors over 10 s, `eta^2` and `0.4 eta^4`, where
    /// `eta = dt sqrt(mu / r^3)` is the part of a radian that a step is at the horizon (or, where that is smaller, at a
    /// twentieth of the way from the emitter).
    fn black_hole(&self, law: &LawScene, from_m: Vec3, dt_s: f64) -> (BlackHole, String) {
        let holes: Vec<_> = self.attractors.iter().map(Attractor::hole).collect();
        let eta = self.attractors.iter().map(|it| {
            let way = f64::from(from_m.distance(Vec3::from(it.at_m)));
            let r = f64::from(it.horizon_m).max(way / 20.0).max(1e-6);
            dt_s * (f64::from(it.mu_m3ps2) / (r * r * r)).sqrt()
        });
        let eta = eta.fold(0.0, f64::max);
        let of = |integrator, substeps| BlackHole { holes: holes.clone(), integrator, substeps };
        if let Some(integrator) = law.integrator.as_deref().and_then(Integrator::named) {
            let substeps = law.substeps.unwrap_or(1);
            let reason = format!("`black_hole` by {integrator}, {substeps} substeps, as the scene asks; a step is {eta:.3} rad at the horizon");
            return (of(integrator, substeps), reason);
        }
        let closed = of(Integrator::Kepler, 1);
        if closed.check().is_ok() {
            let reason = "`black_hole` by kepler: one hole, not circling, has a closed form; expected error 1e-4 of the way at the most".to_owned();
            return (closed, reason);
        }
        let tolerance = law.tolerance;
        let least =
            |scale: f64, order: f64| (eta * (scale / tolerance).powf(1.0 / order)).ceil().clamp(1.0, 1024.0);
        let (leapfrog, rk4) = (least(1.0, 2.0), least(0.4, 4.0));
        // Forces: 1 a substep, or 4.
        let (integrator, substeps, expected) = if leapfrog <= 4.0 * rk4 {
            (Integrator::Leapfrog, leapfrog, (eta / leapfrog).powi(2))
        } else {
            (Integrator::Rk4, rk4, (0.4 * (eta / rk4).powi(4)).max(2e-5))
        };
        let reason = format!(
            "`black_hole` by {integrator}, {substeps} substeps: the cheapest within tolerance {tolerance}; expected error {expected:.1e} of the \
             way in 10 s (99 % of particles); a step is {eta:.3} rad at the horizon"
        );
        (of(integrator, substeps as u32), reason)
    }

    fn load_texture(&self, file: &str) -> Result<([u32; 2], Vec<u8>), SceneError> {
        let path = self.base_dir.as_deref().unwrap_or(Path::new("")).join(file);
        let bytes = fs::read(&path)
            .map_err(|source| SceneError::Read { path: path.display().to_string(), source })?;
        let bad = |reason: String| SceneError::Shader { file: file.to_owned(), reason };
        let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        decoder
            .set_transformations(png::Transformations::normalize_to_color8() | png::Transformations::ALPHA);
        let mut reader = decoder.read_info().map_err(|error| bad(format!("not a PNG: {error}")))?;
        let info = reader.info();
        let size = [info.width, info.height];
        if size.iter().any(|&side| side > MOST_TEXELS) {
            return Err(bad(format!(
                "is {} x {} pixels; allowed: up to {MOST_TEXELS} each",
                size[0], size[1]
            )));
        }
        let room = reader.output_buffer_size().ok_or_else(|| bad("is too large".into()))?;
        let mut pixels = vec![0; room];
        let frame = reader.next_frame(&mut pixels).map_err(|error| bad(format!("not a PNG: {error}")))?;
        pixels.truncate(frame.buffer_size());
        let rgba = match frame.color_type.samples() {
            2 => pixels.chunks_exact(2).flat_map(|it| [it[0], it[0], it[0], it[1]]).collect(),
            4 => pixels,
            other => return Err(bad(format!("has {other} channels"))),
        };
        Ok((size, rgba))
    }
}

/// Along each side of a texture.
const MOST_TEXELS: u32 = 2048;

/// Compiles a user's text between what comes before and after it; errors have the lines of the user's file.
fn compile(
    file: &str,
    before: &str,
    text: &str,
    after: &str,
    stage: glsl::Stage,
) -> Result<Vec<u8>, SceneError> {
    let shader = |reason| SceneError::Shader { file: file.to_owned(), reason };
    let compiler = gpu::compiler().map_err(|error| shader(error.to_string()))?;
    let source = format!(
        "#version 460\n#extension GL_GOOGLE_include_directive : require\n{before}#line 1\n{text}\n{after}"
    );
    let words = compiler.compile(&source, file, stage).map_err(|error| {
        let log = error.log.trim_end().to_owned();
        let line = log.split(&format!("{file}:")).nth(1).and_then(|rest| rest.split(':').next());
        let line = line.and_then(|number| number.trim().parse::<usize>().ok());
        let excerpt = line.and_then(|number| Some((number, text.lines().nth(number.checked_sub(1)?)?)));
        let excerpt = excerpt.map_or(String::new(), |(number, text)| format!("\n{number:5} | {text}"));
        shader(format!("does not compile:\n{log}{excerpt}"))
    })?;
    Ok(words.iter().flat_map(|word| word.to_le_bytes()).collect())
}
