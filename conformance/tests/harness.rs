//! The harness is tested first: everything here must be red.

use conformance::variants::{Missing, Variant, present};
use conformance::{Case, Failure, Itself, Known, Suite, cases, check, compare, reference};
use rtrt_core::backend::{Backend, Description, Picture, RenderError, Request};
use rtrt_core::scene::Scene;
use std::sync::OnceLock;

/// The reference's pictures of all cases.
fn suite() -> &'static Suite {
    static SUITE: OnceLock<Suite> = OnceLock::new();
    SUITE.get_or_init(|| Suite::new(cases::all()))
}

/// Renders as the reference does, but for what `change` does to the picture.
struct Changed<F>(rtrt_cpu::Cpu, F);

impl<F: FnMut(&mut Picture) + Send> Backend for Changed<F> {
    fn describe(&self) -> Description {
        Description { kind: "changed".into(), ..self.0.describe() }
    }
    fn render(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        self.0.render(scene, request, picture)?;
        (self.1)(picture);
        Ok(())
    }
}

/// What the harness says of one case after such a change.
fn changed(case: &str, change: impl FnMut(&mut Picture) + Send) -> String {
    let suite = Suite::new(cases::named(case));
    let outcome = suite.run(&mut Changed(reference(), change)).expect("another backend");
    assert_eq!((outcome.cases, outcome.failures.len()), (1, 1), "the change was not found");
    outcome.failures[0].failure.to_string()
}

const CASE: &str = "camera/four_samples";

#[test]
fn a_pixel_off_by_one_bit_is_red() {
    for bit in 0..32 {
        let found = changed(CASE, |picture| picture.pixels[100] ^= 1 << bit);
        assert!(found.starts_with("resolve: pixels[0] at pixel 26,2 sub-ray 0,0"), "{found}");
    }
}

#[test]
fn every_buffer_off_by_one_bit_is_red_and_names_its_stage() {
    let off = |value: &mut f32| *value = f32::from_bits(value.to_bits() ^ 1);
    type Change = fn(&mut rtrt_core::backend::Deferred, &dyn Fn(&mut f32));
    let expectations: [(&str, Change); 6] = [
        ("bin: lists.instance of block", |d, _| *d.lists.last_mut().unwrap() ^= 1),
        ("visibility: hits.t at pixel", |d, off| off(&mut d.hits[77].t)),
        ("surface: surfaces.normal.y at pixel", |d, off| off(&mut d.surfaces[77].normal[1])),
        ("occlusion: masks[0] at pixel", |d, _| d.masks[77] ^= 1),
        ("light: lit.specular.b at pixel", |d, off| off(&mut d.lit[77].specular[2])),
        ("shade: colors.a at pixel", |d, off| off(&mut d.colors[77][3])),
    ];
    let behind: [(&str, Change); 2] = [
        ("occlusion: transmittance[1] at pixel", |d, _| d.transmittance[2 * 77 + 1] ^= 1),
        ("layers: layers[5] at pixel", |d, off| off(&mut d.layers[7 * 77 + 1].t)),
    ];
    let each = behind.map(|(start, change)| ("transparency/four_samples", start, change));
    for (case, start, change) in
        expectations.map(|(start, change)| (CASE, start, change)).into_iter().chain(each)
    {
        let found = changed(case, |picture| change(picture.deferred.as_mut().unwrap(), &off));
        assert!(found.starts_with(start), "{found}");
        // Ray 77 is in the first block's fifth tile.
        assert!(
            start.starts_with("bin") || found.contains("pixel 0,3 sub-ray 1,1 (ray 77, block 0)"),
            "{found}"
        );
        assert!(
            start.starts_with("bin")
                || case != CASE
                || found.contains("; primary ray from [0.0, 0.0, 4.0] along ["),
            "{found}"
        );
    }
}

#[test]
fn nan_against_a_number_is_red_both_ways() {
    let set = |value: f32| move |p: &mut Picture| p.deferred.as_mut().unwrap().lit[3].diffuse[0] = value;
    let found = changed(CASE, set(f32::NAN));
    assert!(found.contains("light: lit.diffuse.r") && found.contains("is 0x7fc00000"), "{found}");
    let (case, _, expected) = suite().pictures().find(|(case, ..)| case.name == CASE).unwrap();
    let (mut nan, mut number) = (expected.clone(), expected.clone());
    set(f32::NAN)(&mut nan);
    set(1.0)(&mut number);
    assert!(compare(&case.request(), &nan, &nan).is_ok());
    assert!(compare(&case.request(), &nan, &number).is_err());
}

#[test]
fn swapped_cases_are_red() {
    let pictures: Vec<_> = suite().pictures().collect();
    for (i, (case, _, expected)) in pictures.iter().enumerate() {
        for (other, _, actual) in &pictures[i + 1..] {
            assert!(
                check(case, expected, actual).is_err(),
                "{} and {} cannot be told apart",
                case.name,
                other.name
            );
        }
    }
}

#[test]
fn a_backend_is_not_compared_with_itself() {
    let suite = Suite::new(cases::named(CASE));
    let Itself(description) = suite.run(&mut reference()).unwrap_err();
    assert_eq!((description.lanes, description.threads), (1, 1));
}

#[test]
fn a_blank_picture_that_nobody_announced_is_red() {
    let (case, _, expected) = suite().pictures().find(|(case, ..)| case.name == CASE).unwrap();
    let mut blank = expected.clone();
    blank.pixels.fill(0xff12_3456);
    assert!(matches!(check(case, &blank, &blank), Err(Failure::Blank)));
    let announced = conformance::Case { blank: true, ..*case };
    assert!(matches!(check(&announced, expected, expected), Err(Failure::NotBlank)));
    assert!(check(&announced, &blank, &blank).is_ok());
}

#[test]
fn a_picture_that_is_not_rendered_is_red() {
    let found = changed(CASE, |picture| *picture = Picture::default());
    assert_eq!(found.split(':').next(), Some("bin"));
    let found = changed(CASE, |picture| picture.deferred = None);
    assert!(found.contains("has 0 words"), "{found}");
}

/// A renderer of a scene that is not quite the one it was given: a vertex has moved by the
/// smallest step there is.
struct Nudged(rtrt_cpu::Cpu);

impl Backend for Nudged {
    fn describe(&self) -> Description {
        Description { kind: "nudged".into(), ..self.0.describe() }
    }
    fn render(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        self.0.render(&nudged(scene), request, picture)
    }
}

/// The scene of one mesh without a transform, a vertex of it moved by one ULP.
fn nudged(scene: &Scene) -> Scene {
    use rtrt_core::scene::{Bvh, Mesh, Sequential};
    let [instance] = scene.instances() else { panic!("one instance") };
    let mut positions = scene.positions().to_vec();
    // Across the view: depths, and with them the lists, stay the same.
    positions[2][1] = f32::from_bits(positions[2][1].to_bits() - 1);
    let indices = scene.mesh_data()[..3 * instance.triangles as usize].to_vec();
    let mesh = Mesh::new(positions, scene.attributes().to_vec(), indices).unwrap();
    let mut other = Scene::new();
    let material = scene.instance_index(0).and_then(|instance| scene.material_of(instance)).unwrap();
    let material = *scene.material(material).unwrap();
    let material = other.add_material(material).unwrap();
    let index = other.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
    other.add_instance(index, material, glam::Mat4::IDENTITY).unwrap();
    scene.lights().iter().for_each(|&light| other.add_light(light));
    other
}

#[test]
fn a_perturbed_kernel_is_red() {
    let suite = Suite::new(cases::named("visibility/one_triangle"));
    let outcome = suite.run(&mut Nudged(reference())).unwrap();
    let found = outcome.failures[0].failure.to_string();
    assert!(found.starts_with("visibility: hits."), "{found}");

    let found = changed(CASE, |picture| {
        for hit in &mut picture.deferred.as_mut().unwrap().hits {
            hit.t = f32::from_bits(hit.t.to_bits() + 1);
        }
    });
    assert!(found.starts_with("visibility: hits.t at pixel 0,0 sub-ray 0,0"), "{found}");
}

#[test]
fn the_oracles_find_a_wrong_hit_a_wrong_shadow_and_wrong_light() {
    let (case, scene, expected) = suite().pictures().find(|(case, ..)| case.name == "shadow/point").unwrap();
    let request = case.request();
    let brute = |picture: &Picture| conformance::oracle::brute::check(scene, &request, picture, 1);
    let wide = |picture: &Picture| conformance::oracle::wide::check(scene, &request, picture, 1);
    assert!(brute(expected).is_ok() && wide(expected).is_ok());

    let mut wrong = expected.clone();
    wrong.deferred.as_mut().unwrap().hits[400].t *= 1.001;
    assert_eq!(brute(&wrong).unwrap_err().stage, "visibility");
    assert!(wide(&wrong).unwrap_err().contains("ray 400"));

    let mut wrong = expected.clone();
    wrong.deferred.as_mut().unwrap().masks.iter_mut().for_each(|mask| *mask ^= 1);
    assert_eq!(brute(&wrong).unwrap_err().stage, "occlusion");
    assert!(wide(&wrong).unwrap_err().contains("light 0 is lit"));

    let mut wrong = expected.clone();
    let lit = &mut wrong.deferred.as_mut().unwrap().lit;
    lit.iter_mut().for_each(|lit| lit.diffuse = lit.diffuse.map(|channel| channel * 1.001));
    assert!(wide(&wrong).unwrap_err().contains("of light arrives"));
}

#[test]
fn a_missing_gpu_is_a_failure_where_one_is_required() {
    let missing = |is_required| Variant {
        name: "a device",
        backend: Err(Missing { reason: "there is none".into(), is_required }),
    };
    let here = || Variant { name: "the reference", backend: Ok(Box::new(reference())) };
    let counts = |is_required, requires_gpu| {
        let present = present(vec![missing(is_required), here()], requires_gpu);
        assert_eq!(present.backends.len(), 1);
        [present.skipped, present.failed]
    };
    assert_eq!(counts(true, true), [1, 1]);
    assert_eq!([counts(true, false), counts(false, true)], [[1, 0]; 2]);
}

#[test]
fn a_known_failure_must_fail() {
    let known = Some(Known { adapter: "scalar", why: "it is a test" });
    let case = Case { known, ..*cases::named(CASE).unwrap() };
    let suite = Suite::new([&*Box::leak(Box::new(case))]);
    let change = |by: u32| Changed(reference(), move |picture: &mut Picture| picture.pixels[0] ^= by);
    let fails = suite.run(&mut change(1)).unwrap();
    assert_eq!([fails.known.len(), fails.failures.len()], [1, 0]);
    let passes = suite.run(&mut change(0)).unwrap();
    assert_eq!(passes.known.len(), 0);
    assert!(matches!(passes.failures[0].failure, Failure::Passes { why: "it is a test" }));
}

#[test]
fn names_are_unique_and_claims_are_made() {
    let names: std::collections::BTreeSet<_> = cases::all().map(|case| case.name).collect();
    assert_eq!(names.len(), cases::all().count());
    assert!(cases::all().all(|case| case.claim.ends_with('.')));
}
