//! What layers and colored shadows come to, in numbers.

use conformance::reference;
use conformance::shape::{Build, Shape};
use glam::Vec3;
use rtrt_core::backend::{Backend, Deferred, Picture, Request};
use rtrt_core::layout::{Backdrop, NONE, Wrap};
use rtrt_core::scene::{Camera, Image, Light, Material, Panorama, Projection, Scene};
use rtrt_core::schedule::Stage;

/// A material that blends and shows its color whatever the light.
fn glass(base: [f32; 3], alpha: f32) -> Material {
    unlit(base).blend(alpha)
}

fn unlit(base: [f32; 3]) -> Material {
    Material::new(base).unlit(true)
}

/// A square across the view.
fn square(z: f32) -> Shape {
    Shape::quad([-3.0, -3.0, z], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0])
}

fn render(scene: &Scene, eye: Vec3, look_at: Vec3, layers: u32) -> (Picture, Deferred) {
    let projection = Projection::Orthographic { height: 0.3 };
    let camera = Camera { eye, look_at, up: Vec3::Y, projection };
    let request = Request::new(&camera, [16, 16]).layers(layers).deferred(true);
    let mut picture = Picture::default();
    reference().render(scene, &request, &mut picture).unwrap();
    let deferred = picture.deferred.take().unwrap();
    (picture, deferred)
}

/// The color that every ray brings back.
fn color(scene: &Scene, layers: u32) -> [f32; 3] {
    let (_, deferred) = render(scene, Vec3::Z * 4.0, Vec3::ZERO, layers);
    let [r, g, b, a] = deferred.colors[0];
    assert!(deferred.colors.iter().all(|&color| color == [r, g, b, a]), "an edge within a surface is seen");
    assert_eq!(a, 1.0);
    [r, g, b]
}

/// The color of every pixel: a background of one color is behind the pixels.
fn seen(scene: &Scene) -> [u8; 3] {
    let (picture, _) = render(scene, Vec3::Z * 4.0, Vec3::ZERO, 8);
    assert!(
        picture.pixels.iter().all(|&pixel| pixel == picture.pixels[0]),
        "an edge within a surface is seen"
    );
    let [color @ .., alpha] = picture.pixels[0].to_le_bytes();
    assert_eq!(alpha, 255);
    color
}

fn near(found: [f32; 3], expected: [f32; 3]) {
    let off = found.iter().zip(&expected).fold(0.0, |most: f32, (a, b)| most.max((a - b).abs()));
    assert!(off < 2e-3, "{found:?}, not {expected:?}");
}

#[test]
fn layers_blend_from_back_to_front() {
    let build = Build::default()
        .shape_of(square(0.0), unlit([1.0, 1.0, 1.0]))
        .shape_of(square(1.0), glass([0.0, 0.0, 1.0], 0.5))
        .shape_of(square(2.0), glass([1.0, 0.0, 0.0], 0.25));
    // Blue over white is (0.5, 0.5, 1); red over that is this.
    let expected = [0.25 + 0.75 * 0.5, 0.75 * 0.5, 0.75];
    near(color(&build.scene, 8), expected);
    near(color(&build.scene, 3), expected);
    // The last layer that may be looked at counts as opaque.
    near(color(&build.scene, 2), [0.25, 0.0, 0.75]);
    near(color(&build.scene, 1), [1.0, 0.0, 0.0]);
}

/// A wall whose mask has one texel on the left and one on the right.
fn masked(alpha: [u8; 2], cutoff: f32) -> Scene {
    let mut build = Build::default();
    let rgba = alpha.map(|a| [255, 255, 255, a]).concat();
    let image = Image { width: 2, height: 1, rgba };
    let map = build.scene.add_texture(&image, [Wrap::Clamp; 2]).unwrap();
    let material = unlit([1.0, 0.0, 0.0]).mask(cutoff).base_color_map(map);
    build.shape_of(square(0.0), material).shape_of(square(-1.0), unlit([0.0, 1.0, 0.0])).scene
}

#[test]
fn a_mask_is_there_where_alpha_is_not_below_the_cutoff() {
    let middle = |alpha, cutoff| {
        // Between the centers of the texels, alpha rises by its difference.
        let (_, deferred) = render(&masked(alpha, cutoff), Vec3::Z * 4.0, Vec3::ZERO, 8);
        deferred.hits.iter().filter(|hit| hit.instance == 0).count()
    };
    assert_eq!([middle([0, 255], 0.5), middle([255, 0], 0.5)], [128; 2]);
    assert_eq!([middle([0, 0], 0.5), middle([255, 255], 0.5)], [0, 256]);
    assert_eq!([middle([255, 255], 1.0), middle([254, 255], 1.0), middle([0, 0], 0.0)], [256, 0, 256]);
    let (_, deferred) = render(&masked([0, 255], 0.5), Vec3::Z * 4.0, Vec3::ZERO, 8);
    assert!(deferred.layers.is_empty() && deferred.colors.contains(&[0.0, 1.0, 0.0, 1.0]));
}

#[test]
fn what_is_behind_everything_shines_through() {
    let mut build = Build::default().shape_of(square(0.0), glass([1.0, 0.0, 0.0], 0.5));
    build.scene.background = Vec3::new(0.0, 0.5, 1.0);
    // sRGB of 0.5 and 0.25.
    assert_eq!(seen(&build.scene), [188, 137, 188]);
}

#[test]
fn a_pane_that_covers_nothing_is_not_seen_and_colors_nothing() {
    let wall = || Build::default().shape_of(square(0.0), unlit([0.3, 0.6, 0.9]));
    let behind = wall().shape_of(square(1.0), glass([1.0, 0.0, 0.0], 0.0));
    assert_eq!(color(&behind.scene, 8), color(&wall().scene, 8));
}

#[test]
fn an_opaque_scene_has_no_layers_and_no_colored_shadows() {
    let scene = Build::default().shape(square(0.0)).light(Light::sun([0.0, 0.0, -1.0])).scene;
    let (_, deferred) = render(&scene, Vec3::Z * 4.0, Vec3::ZERO, 8);
    assert!(deferred.layers.is_empty() && deferred.transmittance.is_empty());
}

/// What the sun leaves of itself on a floor under panes, of which each has a color, an alpha
/// and a height.
fn transmittance(panes: &[([f32; 3], f32, f32)]) -> Vec<u32> {
    let mut build = Build::default().shape(Shape::floor(4.0, 0.0)).light(Light::sun([0.0, -1.0, 0.0]));
    for &(base, alpha, y) in panes {
        build = build.shape_of(Shape::floor(4.0, y), glass(base, alpha));
    }
    // From below the panes.
    let (_, deferred) = render(&build.scene, Vec3::new(0.0, 0.8, 0.5), Vec3::ZERO, 8);
    assert!(deferred.hits.iter().all(|hit| hit.instance == 0 || hit.instance == NONE));
    deferred.transmittance
}

#[test]
fn the_order_of_panes_does_not_matter_to_shadows() {
    let (red, blue, grey) = ([1.0, 0.1, 0.0], [0.0, 0.2, 1.0], [0.5; 3]);
    let one = transmittance(&[(red, 0.2, 1.0), (blue, 0.4, 2.0), (grey, 0.1, 3.0)]);
    assert_eq!(one, transmittance(&[(red, 0.2, 3.0), (blue, 0.4, 1.0), (grey, 0.1, 2.0)]));
    assert_eq!(one, transmittance(&[(grey, 0.1, 1.0), (blue, 0.4, 2.0), (red, 0.2, 3.0)]));
    assert_ne!(one, transmittance(&[(red, 0.4, 1.0), (blue, 0.2, 2.0), (grey, 0.1, 3.0)]));
}

#[test]
fn shadows_are_as_dark_as_the_alphas_together() {
    let white = [1.0; 3];
    assert!(transmittance(&[]).is_empty());
    assert!(transmittance(&[(white, 0.0, 1.0)]).iter().all(|&word| word == (1 << 30) - 1));
    let quarter = [1.0, 2.0, 3.0, 4.0].map(|y| (white, 0.25, y));
    assert!(transmittance(&quarter).iter().all(|&word| word == 0), "light leaks");
    // Half arrives: √½ of 1023.
    let half = 723 * (1 | 1 << 10 | 1 << 20);
    assert!(transmittance(&quarter[..2]).iter().all(|&word| word == half));
}

#[test]
fn what_is_behind_everything_is_behind_panes() {
    let pane = || Build::default().shape_of(square(1.0), glass([0.0, 0.0, 1.0], 0.5)).scene;
    let around = |mut scene: Scene| {
        let rgb = vec![[0.25, 1.0, 0.5]; 8];
        scene.set_environment(&Panorama { width: 4, height: 2, rgb }).unwrap();
        scene
    };
    let red = |backdrop| {
        let mut scene = around(pane());
        (scene.background, scene.backdrop) = (Vec3::X, backdrop);
        scene
    };
    near(color(&red(Backdrop::Environment), 8), [0.125, 0.5, 0.75]);
    assert_eq!(seen(&red(Backdrop::Color)), [188, 0, 188]);
    let mut plain = pane();
    plain.background = Vec3::X;
    assert_eq!(seen(&plain), [188, 0, 188]);
    // Before nothing, a pane covers as much as its alpha says, and has its own color.
    let (picture, deferred) = render(&red(Backdrop::Nothing), Vec3::Z * 4.0, Vec3::ZERO, 8);
    assert_eq!((deferred.colors[0], picture.pixels[0]), ([0.0, 0.0, 0.5, 0.5], 0x80ff_0000));
    let (picture, deferred) = render(&red(Backdrop::Nothing), Vec3::Z * -4.0, Vec3::Z * -5.0, 8);
    assert_eq!((deferred.colors[0], picture.pixels[0]), ([0.0; 4], 0));
    // The last layer of all counts as opaque; nothing does not.
    let (picture, _) = render(&red(Backdrop::Nothing), Vec3::Z * 4.0, Vec3::ZERO, 1);
    assert_eq!(picture.pixels[0], 0xffff_0000);
    let (picture, _) = render(&red(Backdrop::Nothing), Vec3::Z * -4.0, Vec3::Z * -5.0, 1);
    assert_eq!(picture.pixels[0], 0);
}

/// Clear glass of a body.
fn body(roughness: f32) -> Material {
    Material::new([1.0; 3]).transmission(1.0, None).refraction(1.5).roughness(roughness).double_sided(true)
}

/// Adds an environment, white above the horizon and black below it.
fn under_a_white_sky(build: Build) -> Scene {
    let mut scene = build.scene;
    let rgb = (0..64 * 32).map(|texel| [if texel < 64 * 16 { 1.0 } else { 0.0 }; 3]).collect();
    scene.set_environment(&Panorama { width: 64, height: 32, rgb }).unwrap();
    scene.backdrop = Backdrop::Environment;
    scene
}

#[test]
fn a_ball_of_glass_turns_the_world_over() {
    let ball = Shape::ball(48).at([0.0; 3], 0.125);
    let scene = under_a_white_sky(Build::default().shape_of(ball, body(0.0)));
    // Rays go along the horizon. Those that meet the ball above its middle go down behind it, by 2 (i - r).
    let (picture, _) = render(&scene, Vec3::Z * 4.0, Vec3::ZERO, 8);
    let red = |row: usize| picture.pixels[row * 16 + 8] & 255;
    assert!(red(5) < 130 && red(10) > 220, "{} {}", red(5), red(10));
    // Straight through a pane of the same glass.
    let pane = under_a_white_sky(Build::default().shape_of(square(0.0), body(0.0)));
    let (picture, _) = render(&pane, Vec3::new(0.0, -1.5, 4.0), Vec3::ZERO, 8);
    assert!(picture.pixels.iter().all(|pixel| pixel & 255 > 240), "{:x}", picture.pixels[0]);
}

#[test]
fn rough_glass_blurs_what_is_behind_everything() {
    let red = |roughness| {
        let pane = under_a_white_sky(Build::default().shape_of(square(0.0), body(roughness)));
        // Upward by 20 degrees, so that a wide lobe reaches below the horizon.
        render(&pane, Vec3::new(0.0, -1.5, 4.0), Vec3::ZERO, 8).0.pixels[0] & 255
    };
    let (clear, blurred) = (red(0.0), red(0.7));
    assert!(clear > 240 && blurred < clear - 10, "{clear} {blurred}");
}

#[test]
fn layers_behind_the_first_are_a_stage_of_their_own_in_times() {
    let time = |material: Material| {
        let scene =
            Build::default().shape_of(square(0.0), material).shape_of(square(-1.0), unlit([0.5; 3])).scene;
        render(&scene, Vec3::Z, Vec3::ZERO, 8).0.stages_ms[Stage::Layers as usize]
    };
    assert_eq!(time(unlit([0.2; 3])), 0.0);
    assert!(time(glass([0.2; 3], 0.5)) > 0.0);
}
