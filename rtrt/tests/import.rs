//! Import of real scenes, and of files that are broken on purpose. Both lie outside of the
//! repository; without them the tests that need them say that they are skipped.

use rtrt::import::{ImportError, Loaded, framing, load};
use rtrt_core::backend::{Request, Shadows};
use rtrt_core::layout::{AlphaKind, Attribute, MaterialRecord};
use rtrt_core::scene::{Camera, LightKind, MeshError, Projection, Sequential, Setup};
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The folder of test scenes, if it is there.
fn scenes() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes"));
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: no test scenes at {}", folder.display());
    None
}

/// Where [`written`] writes.
fn written_to() -> PathBuf {
    std::env::temp_dir().join(format!("rtrt-import-{}", std::process::id()))
}

/// A scene written for one test.
fn written(name: &str, text: &str) -> Result<Loaded, ImportError> {
    std::fs::create_dir_all(written_to()).unwrap();
    let path = written_to().join(name);
    std::fs::write(&path, text).unwrap();
    load(&path, &Sequential)
}

/// Triangles stored, drawn, and cameras.
const REAL: &[(&str, u64, u64, usize)] = &[
    ("alpha/AlphaBlendModeTest.glb", 61, 61, 1),
    ("anim/AnimatedTriangle/AnimatedTriangle.gltf", 1, 1, 0),
    ("anim/CesiumMan.glb", 4_672, 4_672, 0),
    ("cad/2CylinderEngine.glb", 75_730, 121_496, 1),
    ("classic/teapot.obj", 992, 992, 0),
    ("cornell/cornell_box/scene.gltf", 32, 32, 0),
    ("features/BoxInterleaved.glb", 12, 12, 0),
    ("features/Cameras/Cameras.gltf", 2, 2, 2),
    ("features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf", 8_192, 8_192, 0),
    ("features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_05.gltf", 2, 2, 0),
    ("features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_06.gltf", 2, 2, 0),
    ("features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_12.gltf", 2, 2, 0),
    ("features/MultiUVTest.glb", 12, 12, 1),
    ("features/PrimitiveModeNormalsTest.glb", 10_488_226, 10_488_226, 0),
    ("features/SimpleSparseAccessor/SimpleSparseAccessor.gltf", 12, 12, 0),
    ("features/TextureTransformTest/TextureTransformTest.gltf", 18, 24, 0),
    ("features/TriangleWithoutIndices/TriangleWithoutIndices.gltf", 1, 1, 0),
    ("features/simple-instancing.glb", 12, 1_500, 0),
    ("hero/Avocado_512/Avocado.gltf", 682, 682, 0),
    ("hero/FlightHelmet/FlightHelmet.gltf", 94_722, 94_722, 0),
    ("hero/chess-board.glb", 178_848, 178_848, 0),
    ("invalid/unsupported/heart_draco.glb", 180, 180, 0),
    ("lights/Lights.glb", 12, 12, 1),
    ("obj/spider/spider.obj", 1_368, 1_368, 0),
    ("outdoor/forest_2000_instances.glb", 13_926, 2_277_600, 0),
    ("outdoor/house.glb", 10_497, 10_497, 0),
    ("outdoor/terrain_lowpoly.glb", 3_868, 3_868, 0),
    ("sponza/sponza_dabrovic.obj", 76_154, 76_154, 0),
    ("sponza/sponza_dabrovic_cc0tex.glb", 76_154, 76_154, 1),
    ("stanford/bunny.glb", 69_630, 69_630, 0),
    ("stanford/bunny_low.obj", 3_674, 3_674, 0),
    ("stanford/dragon_res2.glb", 202_520, 202_520, 0),
    ("stanford/dragon_res4_no_normals.glb", 11_102, 11_102, 0),
];

#[test]
fn real_scenes_have_all_their_triangles() {
    let Some(folder) = scenes() else { return };
    for &(file, stored, drawn, cameras) in REAL {
        let loaded = load(&folder.join(file), &Sequential).unwrap_or_else(|error| panic!("{error}"));
        let scene = &loaded.scene;
        assert_eq!(
            (scene.triangles(), scene.drawn_triangles(), loaded.cameras.len()),
            (stored, drawn, cameras),
            "{file}"
        );
        assert!(!loaded.warnings.iter().any(|w| w.contains("checker")), "{file}: {:?}", loaded.warnings);
    }
}

#[test]
fn instances_share_one_mesh() {
    let Some(folder) = scenes() else { return };
    let forest = load(&folder.join("outdoor/forest_2000_instances.glb"), &Sequential).unwrap().scene;
    let tree = load(&folder.join("outdoor/low-poly-tree.glb"), &Sequential).unwrap().scene;
    assert!(forest.instances().len() > 2000);
    assert!(forest.bytes() < 10 * tree.bytes() + (2 << 20), "{} bytes", forest.bytes());
}

#[test]
fn the_same_atrium_from_obj_and_gltf_has_the_same_extent() {
    let Some(folder) = scenes() else { return };
    let extent =
        |file: &str| load(&folder.join("sponza").join(file), &Sequential).unwrap().scene.extent().unwrap();
    let (a, b) = (extent("sponza_dabrovic.obj"), extent("sponza_dabrovic_cc0tex.glb"));
    assert!((a.0 - b.0).abs().max_element() < 1e-3 && (a.1 - b.1).abs().max_element() < 1e-3, "{a:?} {b:?}");
}

/// Files without errors, as the official validator sees it, that are refused all the same.
const REFUSED: &[(&str, &str)] = &[(
    "base/root/named_objects.gltf",
    "the buffer of what it draws has no bytes, nor a place to look for them",
)];

/// What the files in `invalid` end in.
#[test]
fn broken_files_are_refused_in_one_line_or_drawn() {
    let Some(folder) = scenes() else { return };
    let mut files = Vec::new();
    collect(&folder.join("invalid"), &mut files);
    assert!(files.len() > 200, "only {} files", files.len());
    for file in &files {
        let start = Instant::now();
        let result = catch_unwind(|| load(file, &Sequential).map(|loaded| loaded.scene.triangles()));
        let result = result.unwrap_or_else(|_| panic!("{} made the import panic", file.display()));
        assert!(start.elapsed() < Duration::from_secs(5), "{}", file.display());
        if let Err(error) = result {
            let line = error.to_string();
            assert!(!line.contains('\n') && line.contains(&*file.to_string_lossy()), "{line}");
        }
    }
}

/// What is made of each file of the official validator's, with what the validator says of it: file, its number of
/// errors, `drawn` or `refused`, and the codes of the errors. Errors that do not matter for drawing (of what is not
/// drawn, of what can be drawn all the same) are no reason to refuse a file. `RTRT_RECORD=1` writes it anew.
const VALIDATOR: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/validator.tsv");

#[test]
fn every_file_of_the_validator_is_accounted_for() {
    let Some(folder) = scenes() else { return };
    let folder = folder.join("invalid/gltf-validator");
    let table = std::fs::read_to_string(folder.join("expected.tsv")).unwrap();
    let mut rows = String::new();
    for row in table.lines().skip(1) {
        let columns: Vec<&str> = row.split('\t').collect();
        let (file, errors, codes) = (columns[0], columns[1], columns[4]);
        let outcome = match load(&folder.join(file), &Sequential) {
            Ok(_) => "drawn",
            Err(error) => {
                let is_known = REFUSED.iter().any(|(known, _)| *known == file);
                assert!(errors != "0" || is_known, "{file} has no errors, and is refused: {error}");
                "refused"
            }
        };
        rows += &format!("{file}\t{errors}\t{outcome}\t{codes}\n");
    }
    assert_eq!(rows.lines().count(), 192);
    if std::env::var_os("RTRT_RECORD").is_some() {
        std::fs::write(VALIDATOR, &rows).unwrap();
    }
    let recorded = std::fs::read_to_string(VALIDATOR).unwrap();
    for (row, recorded) in rows.lines().zip(recorded.lines()) {
        assert_eq!(row, recorded);
    }
    assert_eq!(rows.len(), recorded.len());
}

/// Files of `invalid` that must be refused, with a part of what is said.
const BROKEN: &[(&str, &str)] = &[
    ("assimp-gltf2/IndexOutOfRange/AllIndicesOutOfRange.gltf", "mesh refused"),
    ("assimp-gltf2/IndexOutOfRange/IndexOutOfRange.gltf", "mesh refused"),
    ("assimp-gltf2/RecursiveNodes/RecursiveNodes.gltf", "two parents or is its own ancestor"),
    ("assimp-gltf2/wrongTypes/badArray.gltf", "JSON"),
    ("assimp-gltf2/wrongTypes/badUint.gltf", "JSON"),
    ("gltf-validator/base/glb/bom.glb", "JSON"),
    ("gltf-validator/base/glb/invalid_version.glb", "no known version"),
    ("gltf-validator/base/glb/only_header.glb", "no JSON chunk"),
    ("gltf-validator/base/glb/truncated_chunk_header.glb", "cut off"),
    ("gltf-validator/base/json/empty_file.gltf", "it is empty"),
    ("gltf-validator/base/scene/unresolved_node.gltf", "scenes[0].nodes[0] is not there"),
    ("obj-quirks/malformed.obj", "is not an index"),
    ("tinygltf/BoundsChecking/invalid-buffer-index.gltf", "bufferViews[1].buffer is not there"),
    ("tinygltf/BoundsChecking/invalid-buffer-view-index.gltf", "bufferView is not there"),
    ("tinygltf/BoundsChecking/invalid-primitive-indices.gltf", "is not there"),
    ("unsupported/Box_gltf1.glb", "glTF 1"),
];

#[test]
fn broken_files_say_what_is_broken() {
    let Some(folder) = scenes() else { return };
    for (file, part) in BROKEN {
        let Err(error) = load(&folder.join("invalid").join(file), &Sequential) else {
            panic!("{file} loads")
        };
        let error = error.to_string();
        assert!(error.contains(part), "{error}");
    }
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_owned();
        if path.is_dir() {
            collect(&path, files);
        } else if ["glb", "gltf", "obj"].contains(&ending.as_str()) {
            files.push(path);
        }
    }
}

#[test]
fn vertices_that_are_not_finite_are_refused() {
    for number in ["nan", "inf", "1e30"] {
        let error = written("nan.obj", &format!("v 0 0 0\nv 1 {number} 0\nv 0 1 0\nf 1 2 3\n")).unwrap_err();
        let ImportError::Mesh { source: MeshError::Coordinate { vertex: 1, .. }, .. } = error else {
            panic!("{error}");
        };
    }
}

/// A glTF file with one triangle, whose accessor says `accessor` more.
fn triangle(accessor: &str) -> String {
    // Three vertices: 0 0 0, 1 0 0, 0 1 0.
    let bytes = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"componentType":5126,"type":"VEC3",{accessor}}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "buffers":[{{"byteLength":36,"uri":"data:application/octet-stream;base64,{bytes}"}}]}}"#
    )
}

#[test]
fn counts_beyond_the_bytes_are_refused_before_anything_is_allocated() {
    let loaded = written("fits.gltf", &triangle(r#""bufferView":0,"count":3"#)).unwrap();
    assert_eq!(loaded.scene.triangles(), 1);
    for accessor in [
        r#""bufferView":0,"count":4"#,
        r#""bufferView":0,"count":3,"byteOffset":4"#,
        r#""bufferView":0,"count":18446744073709551615"#,
        r#""bufferView":0,"count":3,"byteOffset":18446744073709551615"#,
        r#""count":4000000000"#,
    ] {
        let error = written("counts.gltf", &triangle(accessor)).expect_err(accessor);
        assert!(matches!(error, ImportError::Invalid { .. }), "{error}");
    }
}

#[test]
fn vertices_without_normals_are_flat() {
    let loaded = written("flat.gltf", &triangle(r#""bufferView":0,"count":3"#)).unwrap();
    assert!(loaded.scene.attributes().iter().all(|a| a.normal == [0.0; 3] && a.color == Attribute::WHITE));
}

#[test]
fn a_missing_texture_is_drawn_and_said() {
    // Whatever this one is taken for, the file is then where the next one looks for it.
    written("textured.mtl", "newmtl a\nmap_Kd nowhere.png\n").unwrap_err();
    let obj = "mtllib textured.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    let loaded = written("textured.obj", obj).unwrap();
    assert!(
        loaded.warnings[0].contains("\"nowhere.png\" is drawn as a magenta checker"),
        "{:?}",
        loaded.warnings
    );
    assert!(loaded.scene.materials()[0].textures[0].levels > 1);
}

#[test]
fn framing_has_all_of_the_scene_in_view() {
    let scene = written("box.obj", "v -3 0 0\nv 5 1 9\nv 2 8 -4\nf 1 2 3\n").unwrap().scene;
    let (low, high) = scene.extent().unwrap();
    for aspect in [0.3, 1.0, 16.0 / 9.0] {
        let camera = framing(&scene, aspect);
        let Projection::Perspective { fov_y } = camera.projection else { panic!() };
        let forward = (camera.look_at - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let tangent = (fov_y * 0.5).tan();
        let mut most = 0.0_f32;
        for corner in 0..8 {
            let pick = |bit: u32, low: f32, high: f32| if corner >> bit & 1 == 0 { low } else { high };
            let to = glam::Vec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
                - camera.eye;
            let depth = to.dot(forward) * tangent;
            assert!(depth > 0.0);
            most = most
                .max(to.dot(right.cross(forward)).abs() / depth)
                .max(to.dot(right).abs() / depth / aspect);
        }
        assert!((0.9..1.0).contains(&most), "{most} of the picture is filled");
    }
}

#[test]
fn the_demo_is_whole_and_the_same_every_time() {
    let (a, b) = (rtrt::demo::matchbox(&Sequential).unwrap(), rtrt::demo::matchbox(&Sequential).unwrap());
    assert!(a.warnings.is_empty() && a.scene.lights().len() == 3 && a.scene.drawn_triangles() > 10_000);
    assert_eq!((a.scene.texels(), a.scene.positions()), (b.scene.texels(), b.scene.positions()));
    let glass = rtrt::demo::glass(&Sequential).unwrap();
    assert!(
        glass.warnings.is_empty() && glass.scene.instances().iter().any(|object| object.transparency != 0)
    );
}

#[test]
fn positions_that_are_not_there_are_refused() {
    let text = triangle(r#""bufferView":0,"count":3"#).replace(r#""POSITION":0"#, r#""POSITION":4294967295"#);
    let error = written("positions.gltf", &text).unwrap_err().to_string();
    assert!(error.ends_with("meshes[0].primitives[0].attributes.POSITION is not there"), "{error}");
}

#[test]
fn extensions_that_are_not_supported_are_named() {
    let used = triangle(r#""bufferView":0,"count":3"#)
        .replace(r#""nodes""#, r#""extensionsUsed":["KHR_texture_transform","EXT_of_mine"],"nodes""#);
    let loaded = written("used.gltf", &used).unwrap();
    assert_eq!(loaded.warnings, [r#"the extension "EXT_of_mine" is not supported"#]);
    let required = used.replace("extensionsUsed", "extensionsRequired");
    let error = written("required.gltf", &required).unwrap_err();
    assert!(error.to_string().ends_with("it requires the extension EXT_of_mine"), "{error}");
}

#[test]
fn quantized_positions_are_whole_numbers() {
    let text = triangle(r#""bufferView":0,"count":3"#)
        .replace("5126", "5122")
        .replace(r#""byteLength":36}],"#, r#""byteLength":24,"byteStride":8}],"#)
        .replace(r#""byteLength":36,"#, r#""byteLength":24,"#)
        .replace("AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA", "AAAAAAAAAABkAAAAAAAAAAAAZAAAAAAA")
        .replace(r#""nodes""#, r#""extensionsRequired":["KHR_mesh_quantization"],"nodes""#);
    let loaded = written("quantized.gltf", &text).unwrap();
    assert_eq!(loaded.scene.positions()[1..], [[100.0, 0.0, 0.0], [0.0, 100.0, 0.0]]);
}

#[test]
fn materials_say_what_textures_they_have_and_where_they_lie() {
    let Some(folder) = scenes() else { return };
    let materials = |file: &str| load(&folder.join(file), &Sequential).unwrap().scene.materials().to_vec();
    let helmet = materials("hero/FlightHelmet/FlightHelmet.gltf");
    let has = |place: usize| helmet.iter().filter(|m| m.textures[place].levels > 1).count();
    let places =
        [MaterialRecord::COLOR, MaterialRecord::NORMAL, MaterialRecord::ROUGHNESS, MaterialRecord::OCCLUSION];
    assert_eq!(places.map(has), [6, 6, 6, 6]);
    assert_eq!(has(MaterialRecord::EMISSION), 0);
    let cube = materials("features/MultiUVTest.glb");
    let sets = cube[0].textures.map(|t| (t.levels > 0, t.set));
    assert!(sets.contains(&(true, 1)) && sets.contains(&(true, 0)), "{sets:?}");
    let turned = materials("features/TextureTransformTest/TextureTransformTest.gltf");
    assert!(turned.iter().any(|m| m.textures[0].shift != [0.0; 2]));
    assert!(turned.iter().any(|m| m.textures[0].turn[0][1] != 0.0));
}

#[test]
fn materials_say_what_their_alpha_does() {
    let Some(folder) = scenes() else { return };
    let alphas = |file: &str| -> Vec<_> {
        let loaded = load(&folder.join(file), &Sequential).unwrap();
        loaded.scene.materials().iter().map(|m| (m.alpha_mode, m.cutoff, m.alpha)).collect()
    };
    let [mask, blend] = [AlphaKind::Mask, AlphaKind::Blend].map(|mode| mode as u32);
    let modes = alphas("alpha/AlphaBlendModeTest.glb");
    for expected in [(mask, 0.25, 1.0), (mask, 0.5, 1.0), (mask, 0.75, 1.0), (blend, 0.5, 1.0)] {
        assert!(modes.contains(&expected), "{modes:?}");
    }
    // Glass has layers behind it, and no alpha of its own.
    let glass = load(&folder.join("alpha/TransmissionRoughnessTest.glb"), &Sequential).unwrap();
    let materials = glass.scene.materials().iter();
    let clear = |m: &MaterialRecord| m.transmission == 1.0 && (m.alpha_mode, m.alpha) == (blend, 1.0);
    let ignores_alpha = |m: &MaterialRecord| m.extensions & MaterialRecord::IGNORES_ALPHA != 0;
    assert!(materials.clone().any(|m| clear(m) && ignores_alpha(m)), "{:?}", glass.scene.materials());
}

#[test]
fn materials_say_which_sides_are_seen() {
    let Some(folder) = scenes() else { return };
    let loaded = load(&folder.join("features/TextureSettingsTest.glb"), &Sequential).unwrap();
    let objects = loaded.scene.instances();
    // Materials are seen from one side unless they say that they have two.
    assert_eq!(objects.iter().filter(|object| object.double_sided == 1).count(), 1);
    assert_eq!(objects.len(), 10);
    for object in objects {
        let material = &loaded.scene.materials()[object.material as usize];
        assert_eq!(object.double_sided, material.double_sided);
    }
}

#[test]
fn spot_lights_have_their_cones() {
    let Some(folder) = scenes() else { return };
    let scene = load(&folder.join("lights/Lights.glb"), &Sequential).unwrap().scene;
    let spots = scene.lights().iter().filter(|light| light.kind == LightKind::Spot);
    let cones: Vec<_> = spots.map(|light| (light.inner, light.outer)).collect();
    assert!(
        cones.len() == 2 && cones.iter().all(|(inner, outer)| inner <= outer && *outer < 1.6),
        "{cones:?}"
    );
}

/// A file with a node of three levels of detail, each a triangle of another size and material. `extras` are
/// the first one's, `last` what else there is to say of the last one.
fn levels(extras: &str, last: &str) -> Result<Loaded, ImportError> {
    let corners = [4.0_f32, 2.0, 1.0].map(|size| [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]]);
    let bytes: Vec<u8> = corners.as_flattened().as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    std::fs::create_dir_all(written_to()).unwrap();
    std::fs::write(written_to().join("levels.bin"), bytes).unwrap();
    let each = |of: &dyn Fn(u32) -> String| [of(0), of(1), of(2)].join(",");
    let meshes =
        each(&|i| format!(r#"{{"primitives":[{{"attributes":{{"POSITION":{i}}},"material":{i}}}]}}"#));
    let accessors = each(&|i| {
        format!(r#"{{"bufferView":0,"byteOffset":{},"componentType":5126,"type":"VEC3","count":3}}"#, 36 * i)
    });
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["MSFT_lod"],
        "nodes":[{{"mesh":0,"extensions":{{"MSFT_lod":{{"ids":[1,2]}}}}{extras}}},{{"mesh":1}},{{"mesh":2{last}}}],
        "materials":[{{}},{{}},{{"extensions":{{"MSFT_lod":{{"ids":[1]}}}}}}],"meshes":[{meshes}],
        "accessors":[{accessors}],"bufferViews":[{{"buffer":0,"byteLength":108}}],
        "buffers":[{{"byteLength":108,"uri":"levels.bin"}}]}}"#
    );
    written(&format!("levels-{}.gltf", extras.len() + last.len()), &text)
}

#[test]
fn levels_of_detail_are_chosen_by_what_they_cover() {
    let loaded = levels(r#","extras":{"MSFT_screencoverage":[0.5,0.1,0.001]}"#, "").unwrap();
    assert_eq!(loaded.warnings, ["not drawn: levels of detail of materials"]);
    assert_eq!((loaded.scene.instances().len(), loaded.scene.triangles()), (1, 3));
    // The ball around the triangle has its middle at 2, 2, 0 and this radius.
    let radius = 8.0_f64.sqrt();
    let seen = |scene: &rtrt_core::scene::Scene, share: f64| {
        let tangent = (std::f64::consts::PI / 8.0).tan();
        let away = radius / tangent * (std::f64::consts::PI / (4.0 * 16.0 / 9.0 * share)).sqrt();
        // Straight before the middle, where the bounds are flat: nearer than the ball by its radius.
        let eye = glam::Vec3::new(2.0, 2.0, (away - radius) as f32);
        let camera = Camera { eye, look_at: eye - glam::Vec3::Z, ..loaded.camera };
        let mut setup = Setup::default();
        setup.prepare(scene, &Request::new(&camera, [16, 9]).shadows(Shadows::Off).layers(1)).unwrap();
        let object = setup.instances(scene)[0];
        (object.high[0], object.material, object.triangles)
    };
    for (share, size, material) in
        [(0.9, 4.0, 0), (0.51, 4.0, 0), (0.49, 2.0, 1), (0.11, 2.0, 1), (0.09, 1.0, 2), (0.0011, 1.0, 2)]
    {
        assert_eq!(seen(&loaded.scene, share), (size, material, 1), "{share}");
    }
    assert_eq!(seen(&loaded.scene, 0.0009).2, 0);
    // Without numbers, each begins at a quarter of the one before, and the last goes on for ever.
    let loaded = levels("", "").unwrap();
    for (share, size) in [(0.26, 4.0), (0.24, 2.0), (0.07, 2.0), (0.06, 1.0), (1e-6, 1.0)] {
        assert_eq!(seen(&loaded.scene, share).0, size, "{share}");
    }
    // What cannot take the place of the node is left out.
    let loaded = levels("", r#","translation":[0,0,1]"#).unwrap();
    assert!(
        loaded.warnings[0].ends_with("of node 0 is left out: it is placed elsewhere"),
        "{:?}",
        loaded.warnings
    );
    assert_eq!(seen(&loaded.scene, 1e-6).0, 2.0);
}
