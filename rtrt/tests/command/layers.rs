//! The deferred buffers as layers of an EXR file.

use crate::folder::{Folder, stdout};
use rtrt_core::backend::{Picture, Request, Shadows};
use rtrt_core::grid::Grid;
use rtrt_core::layout::NONE;

/// The samples of a channel of a layer.
fn channel(image: &exr::image::FlatImage, layer: &str, name: &str) -> Vec<u32> {
    let layer =
        image.layer_data.iter().find(|l| l.attributes.layer_name.as_ref().unwrap().eq(layer)).unwrap();
    let channel = layer.channel_data.list.iter().find(|channel| channel.name.eq(name)).unwrap();
    match &channel.sample_data {
        exr::prelude::FlatSamples::F32(samples) => samples.iter().map(|sample| sample.to_bits()).collect(),
        exr::prelude::FlatSamples::U32(samples) => samples.clone(),
        exr::prelude::FlatSamples::F16(_) => panic!("half precision"),
    }
}

#[test]
fn layers_are_the_deferred_buffers() {
    let folder = Folder::new("layers");
    // Renders what the command does.
    let loaded = rtrt::import::load(&folder.0.join("scene.obj"), &rtrt_core::scene::Sequential).unwrap();
    let camera = rtrt::import::framing(&loaded.scene, 37.0 / 21.0);
    let mut scene = loaded.scene;
    rtrt::import::light_by_default(&mut scene).unwrap();
    let mut backend = rtrt_cpu::Cpu::new(rtrt_cpu::Options { lanes: Some(1), threads: Some(1) }).unwrap();
    for samples in [1, 4] {
        let line = "render scene.obj --size 37x21 --aov all.exr -o color.exr --backend cpu --shadows hard";
        stdout(&folder.run(&format!("{line} --samples {samples}")));
        assert_eq!(folder.files().len(), 2);
        let [all, color] = ["all.exr", "color.exr"]
            .map(|name| exr::prelude::read_all_flat_layers_from_file(folder.0.join(name)).unwrap());
        let request = Request::new(&camera, [37, 21]).samples(samples).shadows(Shadows::Hard).deferred(true);
        let mut picture = Picture::default();
        rtrt_core::backend::Backend::render(&mut backend, &scene, &request, &mut picture).unwrap();
        let deferred = picture.deferred.unwrap();
        let grid = Grid { width: 37, height: 21, side: samples.isqrt() };
        assert_eq!(all.layer_data.len(), 11);
        let get = |layer, names: &[&str]| -> Vec<Vec<u32>> {
            names.iter().map(|name| channel(&all, layer, name)).collect()
        };
        let (depth, normal) = (get("depth", &["Z"]), get("normal", &["X", "Y", "Z"]));
        let (object, triangle) = (get("object", &["id"]), get("triangle", &["id", "source"]));
        let (weights, uv) = (get("barycentrics", &["U", "V"]), get("uv", &["U", "V"]));
        let (colors, shadow) = (get("color", &["R", "G", "B", "A"]), get("shadow", &["Y"]));
        let (material, position) = (get("material", &["id"]), get("position", &["X", "Y", "Z"]));
        let albedo = get("albedo", &["R", "G", "B"]);
        let mut hits = 0;
        for pixel in 0..37 * 21 {
            let [x, y] = grid.pixel(pixel);
            let rays: Vec<usize> = (0..samples)
                .map(|n| [x * grid.side + n % grid.side, y * grid.side + n / grid.side])
                .map(|place| grid.index(place).0 as usize)
                .collect();
            let (hit, surface) = (&deferred.hits[rays[0]], &deferred.surfaces[rays[0]]);
            let at = |layer: &[Vec<u32>]| layer.iter().map(|c| c[pixel as usize]).collect::<Vec<_>>();
            let floats = |layer: &[Vec<u32>]| at(layer).into_iter().map(f32::from_bits).collect::<Vec<_>>();
            let is_hit = hit.instance != NONE;
            assert_eq!(floats(&depth), [if is_hit { hit.t } else { f32::INFINITY }]);
            assert_eq!(floats(&uv), surface.uv);
            assert_eq!((at(&object), at(&triangle)[0]), (vec![hit.instance], hit.triangle));
            let instance = scene.instance_index(hit.instance);
            let source = instance.and_then(|instance| scene.source_triangle(instance, hit.triangle));
            assert_eq!(at(&triangle)[1], source.unwrap_or(NONE));
            assert_eq!(floats(&weights), [hit.u, hit.v]);
            assert_eq!(at(&material), [if is_hit { surface.material - 1 } else { NONE }]);
            // The floor is the plane y = 0, and the triangle 5 and 6 has z = 0.
            let axis = if at(&triangle)[1] == 2 { 2 } else { 1 };
            assert!(floats(&position)[axis].abs() < 1e-4, "{:?}", floats(&position));
            let mean = |value: &dyn Fn(usize) -> f32| {
                rays.iter().fold(0.0, |sum, &ray| sum + value(ray)) / samples as f32
            };
            for (i, normal) in floats(&normal).into_iter().enumerate() {
                assert_eq!(normal, mean(&|ray| deferred.surfaces[ray].normal[i]));
            }
            for (i, color) in floats(&colors).into_iter().enumerate() {
                assert_eq!(color, mean(&|ray| deferred.colors[ray][i]));
            }
            assert_eq!(floats(&shadow), [mean(&|ray| deferred.masks[ray].count_ones() as f32)]);
            // The file has no materials: everything is of one color.
            assert!(is_hit || samples > 1 || floats(&albedo) == [0.0; 3]);
            hits += usize::from(is_hit);
        }
        assert!(hits > 50 && hits < 37 * 21, "{hits}");
        assert_eq!(color.layer_data.len(), 1);
        let header = exr::meta::MetaData::read_from_file(folder.0.join("color.exr"), false).unwrap();
        let text = header.headers[0].own_attributes.other.get(&exr::prelude::Text::from("rtrt"));
        let Some(exr::meta::attribute::AttributeValue::Text(json)) = text else { panic!("{text:?}") };
        let shot: serde_json::Value = serde_json::from_str(&json.to_string()).unwrap();
        assert_eq!((&shot["w"], &shot["samples"]), (&37.into(), &samples.into()));
        assert_eq!(shot["camera"], "camera");
        assert_eq!(shot["eye"][0].as_f64().unwrap() as f32, camera.eye.x);
        for (name, expected) in ["R", "G", "B", "A"].iter().zip(&colors) {
            assert_eq!(channel(&color, "color", name), *expected);
        }
    }
}
