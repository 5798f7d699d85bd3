//! What a ray, a pixel or a block needs: compositions of kernels that backends only dispatch, in
//! the order of [`schedule`](crate::schedule).

pub mod ambient;
pub mod beyond;
pub mod bin;
mod coating;
pub mod context;
pub mod detail;
#[cfg(test)]
pub(crate) mod fixture;
#[doc(hidden)]
pub mod inspect;
pub mod light;
pub mod occlusion;
pub mod origin_box;
pub mod peel;
pub mod penumbra_blocks;
pub mod penumbra_filter;
pub mod prepare;
pub mod query;
pub mod raster;
pub mod resolve;
pub mod shade;
pub mod share;
pub mod surface;
pub mod visibility;

#[cfg(test)]
mod tests {
    use super::fixture::{Prepared, add_square, closest, square_at, surfaces};
    use crate::grid::RayIndex;
    use crate::kernel::texture::Maps;
    use crate::lane::flushing::assert_flushing_changes_nothing;
    use crate::lane::{Lane, V3, Word};
    use crate::layout::Wrap;
    use crate::request::Shadows;
    use crate::scene::{Image, Light, Material, Scene};
    use crate::stage::origin_box::OriginBox;
    use glam::Vec3;
    use std::vec::Vec;

    /// A few numbers of each ray from each stage, as words.
    fn traced<L: Lane<Token = (), Bits = Word>>(prepared: &Prepared) -> Vec<[u32; 12]> {
        let (context, scene) = (prepared.context(), &prepared.scene);
        let (frame, camera) = (context.frame, context.camera());
        let maps = Maps { materials: scene.materials(), texels: scene.texels() };
        let all = (0..frame.rays).map(RayIndex).map(|ray| {
            let ([closest], [seen]) = (closest::<L, 1>(prepared, ray), surfaces::<L, 1>(prepared, ray));
            let [direction] = super::visibility::directions::<L, 1>((), frame, camera, ray);
            let [lit] = super::occlusion::word::<L, 1>(&context, 0, ray, &[seen], &OriginBox::new(&[seen]));
            let shadows = super::light::ShadowTerms::new(|_| lit, |_| lit);
            let incoming = super::light::light(frame, context.views, &maps, &shadows, ray, direction, &seen);
            let color = {
                let beyond = super::beyond::Beyond::new(direction);
                super::shade::shade(frame, &maps, direction, &beyond, &seen, &incoming, L::splat((), 1.0))
            };
            let numbers = color.record().map(|channel| channel.lane(0));
            let pixel = super::resolve::resolve::<L>((), frame, |_| numbers, |_| [0.0; 4]);
            let sum = |v: V3<L>| (v.x.to_bits() + v.y.to_bits() + v.z.to_bits()).0;
            let (t, u) = (closest.t.to_bits().0, closest.u.to_bits().0);
            let numbers = numbers.map(f32::to_bits);
            [
                closest.instance.0,
                t,
                u,
                sum(seen.origin),
                sum(seen.normal),
                lit.0,
                sum(incoming.diffuse),
                sum(incoming.specular),
                numbers[0],
                numbers[1],
                numbers[2],
                pixel.0,
            ]
        });
        all.collect()
    }

    #[test]
    fn a_device_that_flushes_denormals_gives_the_same_frame() {
        // Numbers near the least that scenes keep, whose products and squares are denormal.
        let (tiny, small) = (2_f32.powi(-59), 2_f32.powi(-45));
        let mut scene = Scene::new();
        let image = Image { width: 2, height: 2, rgba: (0..16).map(|i| i * 16).collect() };
        let map = scene.add_texture(&image, [Wrap::Mirror; 2]).unwrap();
        let dim = Material::new([tiny, 1.0, small]).base_color_map(map).emission([0.0, tiny, 0.0]);
        add_square(&mut scene, dim, square_at(6.0, [tiny, -tiny, -tiny]));
        let mirror = Material::new(Vec3::splat(small)).metallic(1.0).roughness(0.01);
        add_square(&mut scene, mirror, square_at(2.0, [small, 0.0, 1.0]));
        add_square(&mut scene, Material::default(), square_at(small, [0.5, 0.5, 2.0]));
        let white = scene.add_material(Material::default()).unwrap();
        scene.add_sphere(white, square_at(1.0, [3.0, 3.0, tiny])).unwrap();
        scene.ambient = Vec3::splat(tiny);
        for color in [tiny, small, 2_f32.powi(-20), 1.0] {
            let color = Vec3::new(color, tiny, color);
            scene.add_light(Light::sun([tiny, small, -1.0]).color(color));
            scene.add_light(Light::point([tiny, small, 3.0]).color(color).inverse_square(true).reach(9.0));
            scene.add_light(Light::spot([3.0, 0.0, 3.0], [-0.5, tiny, -1.0], 0.7).color(color));
        }
        let prepared = Prepared::new(scene, |request| request.shadows(Shadows::Hard));
        assert_flushing_changes_nothing!(traced(&prepared), "a frame");
    }
}
