// SPDX-License-Identifier: MIT OR Apache-2.0
//! A world that is changed while it runs: other sizes of pictures, other numbers in its scene, other shaders, and a hand
//! that reaches in. What does not change goes on as it is; a simulation that is made anew goes on from the state of the
//! one before where the two have the same state, and else begins anew.

use super::{effects::Emitters, gas::Gas, lake::Lake, room::Room, source::Source, world, RunError, World};
use crate::{
    disks::{Space, Stir},
    draw::{shadow::Shadow, Camera, Stage},
    gpu::Gpu,
    scene::{EmitterPlan, Plan, Scene, WaterScene},
};
use glam::{vec2, DVec3, UVec2, Vec2, Vec3};

/// What a change has replaced. Pictures on their way may still use it: it is dropped when they are done.
#[derive(Default)]
#[allow(dead_code)] // held, never read
pub struct Left {
    stage: Option<Stage>,
    lakes: Vec<Lake>,
    emitters: Option<Emitters>,
    sources: Vec<Source>,
    gases: Vec<Gas>,
    room: Option<(Room, Shadow)>,
}

/// A ray from the eye through a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// (m).
    pub eye_m: Vec3,
    /// Unit vector.
    pub direction: Vec3,
    /// Of the pixel, from the middle of the picture: -1 to 1, to the right and up.
    pub at: Vec2,
}

impl Ray {
    /// Through the point `at` of a picture that `camera` takes, -1 to 1 from its middle, to the right and up.
    pub fn new(camera: &Camera, size: UVec2, at: Vec2) -> Self {
        let view = crate::draw::View::new(camera, size, 0.0, Vec3::Y, 1.0);
        let ray = view.ray_forward + at.x * view.ray_right + at.y * view.ray_up;
        let direction = ray.truncate().normalize_or(Vec3::NEG_Y);
        Self { eye_m: camera.eye_m, direction, at }
    }

    /// Where it meets the horizontal plane at `y` (m), if it does.
    pub fn at_height(&self, y: f32) -> Option<Vec3> {
        let t = (y - self.eye_m.y) / self.direction.y;
        (t.is_finite() && t > 0.0).then(|| self.eye_m + t * self.direction)
    }

    /// How far from it a point is, as an angle (rad).
    pub fn angle_to(&self, at_m: Vec3) -> f32 {
        (at_m - self.eye_m).angle_between(self.direction)
    }
}

/// What a hand has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touched {
    /// Ripples in a water.
    Water,
    /// Disks are pushed.
    Disks,
}

impl World {
    /// Pictures have another size from now on.
    ///
    /// # Errors
    /// If the device has no room.
    pub fn resize(&mut self, gpu: &Gpu, plan: &Plan, size: UVec2) -> Result<(), RunError> {
        self.stage.resize(gpu, size)?;
        let (shadow, _) = world::around(&self.room);
        self.emitters.redraw(gpu, &self.stage, shadow, &plan.emitters)
    }

    /// Goes on with `scene`, of which `plan` is, after the plan `old`. With `is_all` everything is made anew, as where
    /// shaders have changed.
    ///
    /// # Errors
    /// As [`World::new`]; then nothing has changed.
    pub fn follow(
        &mut self,
        gpu: &Gpu,
        (scene, plan): (&Scene, &Plan),
        old: &Plan,
        is_all: bool,
    ) -> Result<Left, RunError> {
        let depth = |plan: &Plan| plan.emitters.iter().any(EmitterPlan::needs_depth);
        let is_other_place = plan.terrain != old.terrain
            || plan.has_ground() != old.has_ground()
            || scene.output.view != self.scene.output.view
            || depth(plan) != depth(old);
        let is_other_room = (plan.has_shadow() || old.has_shadow())
            && (&plan.meshes, &plan.volume, &plan.paint, &plan.emitters)
                != (&old.meshes, &old.volume, &old.paint, &old.emitters);
        if is_all || is_other_place || is_other_room || scene.seed != self.scene.seed {
            return self.begin_again(gpu, scene, plan, old);
        }
        // Everything is made before anything is replaced.
        let look = world::look_of(scene);
        let ground_m = world::ground_of(gpu, &self.stage, plan)?;
        let mut lakes = Vec::new();
        for (i, (water, planned)) in scene.water.iter().zip(&plan.waters).enumerate() {
            let is_same = self.scene.water.get(i) == Some(water) && old.waters.get(i) == Some(planned);
            lakes.push(match is_same {
                true => None,
                false => {
                    let of = (scene.seed, i as u64);
                    let mut lake = Lake::new(gpu, &self.stage, water, planned, look, of, ground_m.as_ref())?;
                    lake.begin_at(self.time_s);
                    if let Some(was) = self.scene.water.get(i).filter(|was| goes_on(was, water)) {
                        debug_assert_eq!(was.cells, water.cells);
                        lake.go_on_from(gpu, &self.lakes[i])?;
                    }
                    Some(lake)
                }
            });
        }
        let mut gases = Vec::new();
        for (i, disks) in scene.disks.iter().enumerate() {
            gases.push(match self.scene.disks.get(i) {
                Some(was) if was == disks => None,
                was => {
                    let mut gas = Gas::new(gpu, &self.stage, disks, scene)?;
                    if was.is_some_and(|was| same_disks(was, disks)) {
                        gas.go_on_from(gpu, &self.gases[i])?;
                    }
                    Some(gas)
                }
            });
        }
        let splats = |plan: &Plan| plan.emitters.iter().any(|it| it.draw == crate::scene::Draw::Splat);
        let water_m = |scene: &Scene| scene.water.iter().map(|it| it.level_m).fold(f32::MIN, f32::max);
        let is_other_set = splats(plan) != splats(old)
            || plan.emitters.is_empty() != old.emitters.is_empty()
            || water_m(scene) != water_m(&self.scene);
        let mut left = Left::default();
        if is_other_set {
            let around = world::around(&self.room);
            let mut emitters =
                world::emitters_of(gpu, &mut self.stage, scene, plan, ground_m.as_ref(), around)?;
            emitters.go_on_from(&self.emitters)?;
            left.emitters = Some(std::mem::replace(&mut self.emitters, emitters));
        } else {
            let changed = self.emitters.changed(
                gpu,
                &self.stage,
                world::around(&self.room),
                &plan.emitters,
                &old.emitters,
            )?;
            left.sources = self.emitters.replace(changed)?;
        }
        left.lakes = replace(&mut self.lakes, lakes);
        left.gases = replace(&mut self.gases, gases);
        self.adopt(scene, plan);
        Ok(left)
    }

    /// All made anew, with the states that fit. Particles and paint go by meshes: where those or their cells are others, or
    /// the seed, all is from the start.
    fn begin_again(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        plan: &Plan,
        before: &Plan,
    ) -> Result<Left, RunError> {
        let mut new = Self::of_size(gpu, scene, plan, self.stage.size())?;
        let is_alike = scene.seed == self.scene.seed
            && match (&mut new.room, &self.room) {
                (Some((new, _)), Some((old, _)))
                    if (&plan.meshes, &plan.volume) == (&before.meshes, &before.volume) =>
                {
                    new.go_on_from(gpu, old)?
                }
                (new, _) => new.is_none(),
            };
        if is_alike {
            for (i, lake) in new.lakes.iter_mut().enumerate() {
                lake.begin_at(self.time_s);
                let was = self.scene.water.get(i).filter(|was| goes_on(was, &scene.water[i]));
                if was.is_some() && plan.terrain == before.terrain {
                    lake.go_on_from(gpu, &self.lakes[i])?;
                }
            }
            for (i, gas) in new.gases.iter_mut().enumerate() {
                if self.scene.disks.get(i).is_some_and(|was| same_disks(was, &scene.disks[i])) {
                    gas.go_on_from(gpu, &self.gases[i])?;
                }
            }
            new.emitters.go_on_from(&self.emitters)?;
            new.time_s = self.time_s;
        }
        let Self { stage, lakes, emitters, gases, room, .. } = std::mem::replace(self, new);
        Ok(Left { stage: Some(stage), lakes, emitters: Some(emitters), sources: Vec::new(), gases, room })
    }

    fn adopt(&mut self, scene: &Scene, plan: &Plan) {
        self.lamp = world::lamp_of(plan);
        self.scene = scene.clone();
    }

    /// The scene as it is now.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// A hand reaches in along `ray`, for the picture to come: water ripples, disks are pushed away.
    ///
    /// # Errors
    /// If the device has no room.
    pub fn touch(&mut self, gpu: &Gpu, ray: &Ray) -> Result<Option<Touched>, RunError> {
        for (gas, disks) in self.gases.iter_mut().zip(&self.scene.disks) {
            let [x, y, z] = disks.size_m;
            let at_m = match disks.space {
                Space::Flat => {
                    // The box fills the picture, as far as its shape allows: glsl/disks/draw.vert.
                    let pixels = self.stage.size().as_dvec2();
                    let pixels_per_m = (pixels.x / x).min(pixels.y / y);
                    let at = 0.5 * ray.at.as_dvec2() * pixels / pixels_per_m;
                    Some(DVec3::new(at.x + 0.5 * x, at.y + 0.5 * y, 0.0))
                }
                Space::Solid => {
                    let corner = disks.origin_m();
                    ray.at_height(corner.y + 0.25 * y as f32).map(|at| (at - corner).as_dvec3())
                }
            };
            let inside =
                |at: &DVec3| at.x >= 0.0 && at.x <= x && at.y >= 0.0 && at.y <= y && at.z >= 0.0 && at.z <= z;
            if let Some(at_m) = at_m.filter(inside) {
                let radius_m = 0.2 * x.min(y);
                // It carries a disk across its reach in a fifth of a second.
                gas.stir(Some(Stir { at_m, radius_m, push_mps2: 2.0 * radius_m / (0.2 * 0.2) }));
                return Ok(Some(Touched::Disks));
            }
        }
        for lake in &mut self.lakes {
            let (level_m, half_m) = lake.extent();
            let Some(at) = ray.at_height(level_m) else { continue };
            let at = vec2(at.x, at.z);
            if at.abs().cmplt(half_m).all() {
                let radius_m = (2.0 * half_m.min_element() / 40.0).max(2.0 * lake.cell_m());
                lake.throw(gpu, at + half_m, radius_m)?;
                return Ok(Some(Touched::Water));
            }
        }
        Ok(None)
    }

    /// The hand is gone.
    pub fn let_go(&mut self) {
        self.gases.iter_mut().for_each(|gas| gas.stir(None));
    }

    /// Throws from another place from now on (m).
    pub fn move_emitter(&mut self, emitter: usize, at_m: Vec3) {
        self.emitters.move_to(emitter, at_m);
        self.lakes.iter_mut().for_each(|lake| lake.move_emitter(emitter, at_m));
    }

    /// Counters of every simulation. Waits for the device, and reads few words.
    ///
    /// # Errors
    /// The device's.
    pub fn counters(&self) -> Result<Vec<Counters>, RunError> {
        let mut all: Vec<Counters> = self.lakes.iter().map(Lake::counters).collect::<Result<_, _>>()?;
        all.extend(self.emitters.counters()?);
        all.extend(self.gases.iter().map(Gas::counters));
        Ok(all)
    }
}

/// Counters of one simulation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counters {
    /// As in the scene.
    pub name: String,
    /// What is counted, and how many.
    pub counts: Vec<(&'static str, u64)>,
}

/// Puts what is new in its place; returns what was there, and what is no more.
fn replace<T>(all: &mut Vec<T>, new: Vec<Option<T>>) -> Vec<T> {
    let mut left: Vec<T> = all.drain(new.len().min(all.len())..).collect();
    for (i, new) in new.into_iter().enumerate() {
        match (new, all.get_mut(i)) {
            (Some(new), Some(old)) => left.push(std::mem::replace(old, new)),
            (Some(new), None) => all.push(new),
            (None, _) => {}
        }
    }
    left
}

/// The state of one is a state of the other.
fn goes_on(was: &WaterScene, is: &WaterScene) -> bool {
    let of = |it: &WaterScene| (it.model, it.order, it.cells, it.size_m, it.level_m);
    of(was) == of(is) && was.start == is.start && was.barriers == is.barriers && was.depth_m == is.depth_m
}

/// The same disks, in a box of the same size.
fn same_disks(was: &crate::scene::DisksScene, is: &crate::scene::DisksScene) -> bool {
    let of = |it: &crate::scene::DisksScene| (it.space, it.count, it.size_m, it.radius_m, it.speed_mps);
    of(was) == of(is) && (was.from_m, was.to_m) == (is.from_m, is.to_m) && was.heavy == is.heavy
}
