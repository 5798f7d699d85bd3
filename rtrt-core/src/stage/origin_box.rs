//! A box around the surfaces of a packet, which tells the lights that reach none of them.

use crate::lane::{Bits, Lane, V3};
use crate::layout::{View, ViewKind};
use crate::stage::surface::Surfaces;

/// The box around the origins of the shadow rays of a packet.
#[derive(Debug, Clone, Copy)]
pub struct OriginBox {
    low: [f32; 3],
    high: [f32; 3],
}

impl OriginBox {
    /// That of the surfaces that are there. Coordinates that are no numbers do not count: no light is within reach of them.
    #[inline(always)]
    pub fn new<L: Lane, const G: usize>(surfaces: &[Surfaces<L>; G]) -> Self {
        let token = surfaces[0].footprint.token();
        let (mut low, mut high) = (V3::splat(token, [f32::MAX; 3]), V3::splat(token, [-f32::MAX; 3]));
        let mut g = 0;
        while g < G {
            let Surfaces { origin, material, .. } = surfaces[g];
            let is_there = material.gt(material.broadcast(0));
            low = V3::select(is_there, origin.min(low), low);
            high = V3::select(is_there, origin.max(high), high);
            g += 1;
        }
        Self {
            low: [low.x.smallest(), low.y.smallest(), low.z.smallest()],
            high: [high.x.largest(), high.y.largest(), high.z.largest()],
        }
    }

    /// Whether any of the surfaces may be within a light's reach; false if there are none. Where it is false, [`limit`] is
    /// −1 for each of them.
    ///
    /// ```text
    /// |max(low − center, center − high, 0)|² < reach²
    /// ```
    ///
    /// These are the operations by which `limit` finds the distance of a surface. Each of them, rounded, gives no more here than
    /// there.
    ///
    /// [`limit`]: super::occlusion::limit
    #[inline(always)]
    pub fn is_within_reach(&self, light: &View) -> bool {
        if light.kind == ViewKind::Sun as u32 || light.disc != 0.0 {
            return true;
        }
        let away = |axis: usize| {
            let (below, above) = (self.low[axis] - light.center[axis], light.center[axis] - self.high[axis]);
            Lane::max(Lane::max(below, above), 0.0)
        };
        let [x, y, z] = [away(0), away(1), away(2)];
        x * x + y * y + z * z < light.reach_squared
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::RayIndex;
    use crate::request::{Request, Shadows};
    use crate::scene::{Light, Material, Scene};
    use crate::stage::fixture::{Prepared, add_square, square_at, surfaces};
    use crate::stage::occlusion::limit;
    use std::vec::Vec;

    #[test]
    fn no_light_within_reach_is_left_out() {
        let mut seed = 11_u32;
        let mut number = |low: f32, high: f32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            low + (high - low) * (seed >> 8) as f32 / (1 << 24) as f32
        };
        let mut lights: Vec<_> = (0..300)
            .map(|_| {
                let place = [number(-12.0, 12.0), number(-12.0, 12.0), number(-3.0, 6.0)];
                Light::point(place).reach(number(0.2, 6.0))
            })
            .collect();
        lights.push(Light::sun([0.0, 0.0, -1.0]));
        lights.push(Light::point([4.5, 3.5, 1.5]));
        let mut scene = Scene::new();
        add_square(&mut scene, Material::default(), square_at(6.0, [0.0; 3]));
        add_square(&mut scene, Material::default(), square_at(1.0, [0.0, 0.0, 2.0]));
        lights.iter().for_each(|&light| scene.add_light(light));
        let prepared = Prepared::new(scene, |request: Request<'_>| request.shadows(Shadows::Hard));
        let context = prepared.context();
        let mut views: Vec<View> = (0..302).map(|light| *context.light(light)).collect();
        // The last is right above where a ray meets the floor: with reaches from just too short to just long enough.
        let below = |ray: &u32| prepared.frame().grid().ray(RayIndex(*ray)) == [12, 4];
        let seen = surfaces::<f32, 1>(&prepared, RayIndex((0..256).find(below).unwrap()))[0].origin;
        let squared = (1.5 - seen.z) * (1.5 - seen.z);
        let last = views.pop().unwrap();
        views.extend((0..9).map(|step| {
            let reach_squared = f32::from_bits(squared.to_bits() - 4 + step);
            View { center: [seen.x, seen.y, 1.5], reach_squared, ..last }
        }));
        let (mut left_out, mut lit) = (0, [0; 310]);
        for first in (0..256).step_by(16).map(RayIndex) {
            let surfaces = surfaces::<f32, 16>(&prepared, first);
            let around = OriginBox::new(&surfaces);
            for (view, lit) in views.iter().zip(&mut lit) {
                let is_lit = (0..16)
                    .any(|g| limit(context.frame, view, RayIndex(first.0 + g as u32), &surfaces[g]) > 0.0);
                let is_within_reach = around.is_within_reach(view);
                assert!(is_within_reach || !is_lit, "{first:?} {view:?}");
                (left_out, *lit) = (left_out + usize::from(!is_within_reach), *lit + usize::from(is_lit));
            }
        }
        assert!(left_out > 16 * 200, "{left_out}");
        assert!(lit[..300].iter().filter(|lit| **lit > 0).count() > 20);
        // Nine of the 16 tiles have part of the floor, at least.
        assert!(lit[300] >= 9);
        assert_eq!(lit[301..], [0, 0, 0, 0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn what_is_no_number_hides_no_surface() {
        let mut scene = Scene::new();
        add_square(&mut scene, Material::default(), square_at(6.0, [0.0; 3]));
        scene.add_light(Light::point([0.0, 0.0, 1.0]).reach(2.0));
        let prepared = Prepared::new(scene, |request: Request<'_>| request.shadows(Shadows::Hard));
        // A tile in the middle of the floor.
        let first =
            RayIndex((0..256).find(|ray| prepared.frame().grid().ray(RayIndex(*ray)) == [8, 8]).unwrap());
        let all = surfaces::<f32, 16>(&prepared, first);
        let is_within_reach = |surfaces: &[Surfaces<f32>; 16]| {
            OriginBox::new(surfaces).is_within_reach(prepared.context().light(0))
        };
        assert!(is_within_reach(&all));
        for broken in 0..16 {
            let mut surfaces = all;
            surfaces[broken].origin = V3::splat((), [f32::NAN; 3]);
            assert!(is_within_reach(&surfaces), "{broken}");
        }
        let nothing = all.map(|surfaces| Surfaces { material: crate::lane::Word(0), ..surfaces });
        let broken = all.map(|surfaces| Surfaces { origin: V3::splat((), [f32::NAN; 3]), ..surfaces });
        assert!(!is_within_reach(&nothing) && !is_within_reach(&broken));
    }
}
