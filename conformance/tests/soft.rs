//! Shadows of lights with a radius, against closed forms.

use conformance::reference;
use conformance::shape::{Build, Shape};
use glam::Vec3;
use rtrt_core::backend::{Backend, Deferred, Picture, Request, Shadows};
use rtrt_core::grid::Grid;
use rtrt_core::kernel::transmittance::{WHITE, color};
use rtrt_core::lane::Word;
use rtrt_core::scene::{Camera, Light, Material, Projection, Scene};

/// Pixels on a side; the picture is 1.28 units high.
const SIZE: u32 = 128;

/// Looks down on the floor from this height, so that x goes to the right, a pixel being 0.01.
fn above(height: f32) -> Camera {
    let projection = Projection::Orthographic { height: 0.01 * SIZE as f32 };
    Camera { eye: Vec3::Y * height, look_at: Vec3::ZERO, up: Vec3::NEG_Z, projection }
}

fn render(scene: &Scene, camera: &Camera, samples: u32, shadows: Shadows) -> (Picture, Deferred) {
    let request = Request::new(camera, [SIZE; 2]).samples(samples).shadows(shadows).deferred(true);
    let mut picture = Picture::default();
    reference().render(scene, &request, &mut picture).unwrap();
    let deferred = picture.deferred.take().unwrap();
    (picture, deferred)
}

/// A floor, and half a unit or so above it a sheet left of x = 0.
fn sheet(height: f32, material: Option<Material>, light: Light) -> Scene {
    let sheet = Shape::quad([-9.0, height, 9.0], [9.0, 0.0, 0.0], [0.0, 0.0, -18.0]);
    let build = Build::default().shape(Shape::floor(9.0, 0.0));
    match material {
        Some(material) => build.shape_of(sheet, material),
        None => build.shape(sheet),
    }
    .light(light)
    .scene
}

/// The share of the light that arrives along the middle row, and the x there.
fn profile(deferred: &Deferred) -> impl Iterator<Item = (f64, f64)> + '_ {
    let grid = Grid { width: SIZE, height: SIZE, side: 1 };
    (0..SIZE).map(move |x| {
        let ray = grid.index([x, SIZE / 2]).0 as usize;
        let share = color::<f32>(Word(deferred.transmittance[ray])).y;
        ((f64::from(x) + 0.5 - f64::from(SIZE) * 0.5) * 0.01, f64::from(share))
    })
}

/// The share of a disc of radius 1 that lies left of `x`.
fn segment(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / std::f64::consts::PI
}

/// A light above the edge of the sheet, whose penumbra there is as wide as `radius` says.
fn over_the_edge(height: f32, penumbra: f32) -> Light {
    Light::point([0.0, 4.0, 0.0]).radius(penumbra * (4.0 - height) / height)
}

#[test]
fn an_edge_fades_as_the_light_behind_it_appears() {
    for (height, penumbra) in [(0.5, 0.02), (0.5, 0.05), (1.0, 0.13), (1.5, 0.2)] {
        let scene = sheet(height, None, over_the_edge(height, penumbra));
        let (_, deferred) = render(&scene, &above(height * 0.5), 1, Shadows::Soft);
        let (mut worst, mut width) = (0.0_f64, 0);
        for (x, share) in profile(&deferred) {
            worst = worst.max((share - segment(x / f64::from(penumbra))).abs());
            width += u32::from(share > 0.0 && share < 1.0);
        }
        println!("penumbra {penumbra}: {width} pixels, off by {worst}");
        // The outermost pixels of either side see less than 1 % of the light, or of the edge.
        let expected = f64::from(penumbra) * 200.0;
        assert!((f64::from(width) - expected).abs() <= 2.0, "{width} pixels, not {expected}");
        // Few rays across, few levels between.
        assert!(worst < 0.03 + 0.1 * 0.01 / f64::from(penumbra), "off by {worst}");
    }
}

#[test]
fn sixteen_points_fade_as_the_light_behind_them_appears() {
    let scene = sheet(1.0, None, over_the_edge(1.0, 0.13));
    let (_, deferred) = render(&scene, &above(0.5), 16, Shadows::Area { jitter: Some(3) });
    let grid = Grid { width: SIZE, height: SIZE, side: 4 };
    for x in (0..SIZE * 4).step_by(4) {
        // All sub-rays of a column of pixels: 2048 points of the light.
        let lit: u32 = (0..4)
            .flat_map(|a| (0..SIZE * 4).map(move |y| [x + a, y]))
            .map(|at| deferred.masks[grid.index(at).0 as usize])
            .sum();
        let share = f64::from(lit) / f64::from(SIZE * 16);
        let place = (f64::from(x / 4) + 0.5 - f64::from(SIZE) * 0.5) * 0.01;
        // The edge is straight, the light is near: half a pixel's more to the sides.
        assert!((share - segment(place / 0.13)).abs() < 0.06, "{share} at {place}");
    }
}

#[test]
fn shadows_do_not_leak_over_edges() {
    // The edge's shadow ends at 0.67; seen from above, the sheet hides all that is left of 0.
    let scene = sheet(1.0, None, Light::point([-2.0, 4.0, 0.0]).radius(0.3));
    let (_, deferred) = render(&scene, &above(3.0), 1, Shadows::Soft);
    let mut counts = [0; 2];
    for (x, share) in profile(&deferred) {
        if x < 0.0 {
            assert_eq!(share, 1.0, "the sheet is dark at {x}");
            counts[0] += 1;
        } else if x < 0.5 {
            assert_eq!(share, 0.0, "the floor is lit at {x}");
            counts[1] += 1;
        }
    }
    assert!(counts.iter().all(|&count| count > 40), "{counts:?}");
}

#[test]
fn shadows_do_not_leak_around_corners() {
    // A wall at x = 0 that faces the light, and a floor that lies in a sheet's shadow.
    let sheet = Shape::quad([-9.0, 0.3, 9.0], [9.0, 0.0, 0.0], [0.0, 0.0, -18.0]);
    let wall = Shape::quad([0.0, 0.0, 9.0], [0.0, 0.0, -18.0], [0.0, 9.0, 0.0]);
    let build = Build::default().shape(Shape::floor(9.0, 0.0)).shape(sheet).shape(wall);
    let scene = build.light(Light::point([-3.0, 1.5, 0.0]).radius(0.3)).scene;
    let camera = Camera {
        eye: Vec3::new(-0.5, 0.2, 0.0),
        look_at: Vec3::new(0.0, 0.0, 0.0),
        up: Vec3::Y,
        projection: Projection::Orthographic { height: 0.3 },
    };
    let (_, deferred) = render(&scene, &camera, 1, Shadows::Soft);
    let mut seen = [0; 2];
    for (hit, &word) in deferred.hits.iter().zip(&deferred.transmittance) {
        match hit.instance {
            0 => assert_eq!(word, 0, "the floor is lit"),
            2 => assert_eq!(word, 0, "the wall below the sheet is lit"),
            _ => continue,
        }
        seen[hit.instance as usize / 2] += 1;
    }
    assert!(seen.iter().all(|&count| count > 100), "{seen:?}");
}

#[test]
fn shadows_do_not_leak_under_thin_walls() {
    // The floor goes on below a wall without thickness, from a lit room into one that has a roof.
    let wall = Shape::quad([0.0, 0.0, 9.0], [0.0, 0.0, -18.0], [0.0, 3.0, 0.0]);
    let roof = Shape::quad([0.0, 1.0, 9.0], [9.0, 0.0, 0.0], [0.0, 0.0, -18.0]);
    let build = Build::default().shape(Shape::floor(9.0, 0.0)).shape(wall).shape(roof);
    let scene = build.light(Light::point([-1.5, 1.5, 0.0]).radius(0.3)).scene;
    let (_, deferred) = render(&scene, &above(0.9), 1, Shadows::Soft);
    for (x, share) in profile(&deferred) {
        let expected = if x < 0.0 { 1.0 } else { 0.0 };
        assert_eq!(share, expected, "at {x}");
    }
}

#[test]
fn thin_shadows_have_their_penumbras_at_any_angle() {
    let (width, penumbra) = (0.015_f32, 0.08_f32);
    let wire = Shape::quad([-0.375 * width, 1.0, 9.0], [0.75 * width, 0.0, 0.0], [0.0, 0.0, -18.0]);
    let build = Build::default().shape(Shape::floor(9.0, 0.0)).shape(wire);
    let scene = build.light(over_the_edge(1.0, penumbra)).scene;
    let (mut off, mut count) = (0.0, 0);
    for angle in (0..180_u8).step_by(5) {
        let angle = f32::from(angle).to_radians();
        let camera = Camera { up: Vec3::new(angle.sin(), 0.0, -angle.cos()), ..above(0.5) };
        let (_, deferred) = render(&scene, &camera, 1, Shadows::Soft);
        for (surface, &word) in deferred.surfaces.iter().zip(&deferred.transmittance) {
            // Where the whole disc is in the picture.
            let [x, _, z] = surface.origin;
            if x.abs() > 0.7 * penumbra || z.abs() > 0.33 {
                continue;
            }
            let share = f64::from(color::<f32>(Word(word)).y);
            let at = |x: f32| segment(f64::from(x / penumbra));
            assert!(share < 1.0, "nothing of the wire at {x} from it, {z} along it");
            off += (share - 1.0 + at(x + width * 0.5) - at(x - width * 0.5)).abs();
            count += 1;
        }
    }
    let off = off / f64::from(count);
    println!("off by {off}");
    assert!(off < 0.012, "off by {off}");
}

#[test]
fn a_light_without_a_radius_casts_hard_shadows() {
    let scene = |radius| sheet(1.0, None, Light::point([0.3, 4.0, 0.0]).radius(radius));
    let all = [Shadows::Soft, Shadows::Area { jitter: None }, Shadows::Area { jitter: Some(9) }];
    for samples in [1, 4] {
        let (hard, buffers) = render(&scene(0.5), &above(0.5), samples, Shadows::Hard);
        for shadows in all {
            let (picture, deferred) = render(&scene(0.0), &above(0.5), samples, shadows);
            assert_eq!(picture.pixels, hard.pixels, "{shadows:?}");
            assert_eq!(deferred, buffers, "{shadows:?}");
            let (soft, _) = render(&scene(0.5), &above(0.5), samples, shadows);
            let is_hard = soft.pixels == hard.pixels;
            // The one sub-ray of a pixel takes the middle.
            assert_eq!(is_hard, samples == 1 && shadows == Shadows::Area { jitter: None }, "{shadows:?}");
        }
    }
}

#[test]
fn a_light_without_a_radius_casts_hard_shadows_beside_one_with_a_radius() {
    let mut scene = sheet(1.0, None, Light::point([0.3, 4.0, 0.0]));
    let (_, hard) = render(&scene, &above(0.5), 1, Shadows::Hard);
    scene.add_light(Light::point([-0.3, 4.0, 0.0]).radius(0.4));
    let (_, soft) = render(&scene, &above(0.5), 1, Shadows::Soft);
    for (ray, mask) in hard.masks.iter().enumerate() {
        assert_eq!(soft.transmittance[2 * ray], mask * WHITE);
        assert_eq!(soft.masks[ray] & 1, *mask);
    }
}

/// A material that blends and shows its color whatever the light.
fn glass(base: [f32; 3], alpha: f32) -> Material {
    Material::new(base).blend(alpha).unlit(true)
}

#[test]
fn a_pane_fades_from_its_color_to_white() {
    let scene = sheet(1.0, Some(glass([1.0, 0.5, 0.0], 0.5)), over_the_edge(1.0, 0.13));
    let (_, deferred) = render(&scene, &above(0.5), 1, Shadows::Soft);
    // A = 0.5, tint = 0.5: half of the light arrives, three quarters of its green.
    for (x, share) in profile(&deferred) {
        let expected = 0.375 + (1.0 - 0.375) * segment(x / 0.13);
        assert!((share - expected).abs() < 0.04, "{share} at {x}, not {expected}");
    }
}

#[test]
fn the_order_of_panes_does_not_matter() {
    let transmittance = |order: [usize; 3]| {
        let panes = [glass([1.0, 0.1, 0.0], 0.2), glass([0.0, 0.2, 1.0], 0.4), glass([0.5; 3], 0.1)];
        let mut build = Build::default().shape(Shape::floor(9.0, 0.0));
        for (place, pane) in order.into_iter().enumerate() {
            let y = 0.6 + 0.3 * place as f32;
            let shape = Shape::quad([-9.0, y, 9.0], [9.0, 0.0, 0.0], [0.0, 0.0, -18.0]);
            build = build.shape_of(shape, panes[pane]);
        }
        let scene = build.light(over_the_edge(0.6, 0.1)).scene;
        render(&scene, &above(0.3), 1, Shadows::Soft).1.transmittance
    };
    let one = transmittance([0, 1, 2]);
    assert!(one.iter().any(|&word| word != one[0]));
    assert_eq!(one, transmittance([2, 1, 0]));
    assert_eq!(one, transmittance([1, 2, 0]));
}
