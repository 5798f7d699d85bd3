//! Files as exporters write them: small inputs made here, and values that follow from the specifications.

use base64::Engine;
use glam::Vec3;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use rtrt::debug::{DebugView, show};
use rtrt::import::{Loaded, load};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::layout::{AlphaKind, MaterialRecord, Texture};
use rtrt_core::scene::{Camera, Projection, Sequential};
use rtrt_cpu::{Cpu, Options};
use std::path::{Path, PathBuf};

/// A folder with these files, of one test.
fn folder(test: &str, files: &[(&str, &[u8])]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("as-exported").join(test);
    std::fs::remove_dir_all(&folder).ok();
    for (name, bytes) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

/// The scene in the first of these files, without a warning.
fn loaded(test: &str, files: &[(&str, &[u8])]) -> Loaded {
    let loaded = load(&folder(test, files).join(files[0].0), &Sequential).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded
}

/// A PNG file of these texels.
fn png(width: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let height = texels.len() as u32 / width;
    PngEncoder::new(&mut bytes)
        .write_image(texels.as_flattened(), width, height, ExtendedColorType::Rgba8)
        .unwrap();
    bytes
}

/// The view of a scene of x and y within ±1, from +z, 32 pixels wide and high; RGB by row from the top.
fn seen(loaded: &Loaded, view: Option<DebugView>) -> Vec<[u8; 3]> {
    let projection = Projection::Orthographic { height: 2.0 };
    let camera = Camera { eye: Vec3::Z * 5.0, look_at: Vec3::ZERO, up: Vec3::Y, projection };
    let request = Request::new(&camera, [32, 32]).samples(1).shadows(Shadows::Off).deferred(true);
    let mut picture = Picture::default();
    let mut cpu = Cpu::new(Options { lanes: Some(1), threads: Some(1) }).unwrap();
    cpu.render(&loaded.scene, &request, &mut picture).unwrap();
    let pixels = match view {
        Some(view) => show(view, &loaded.scene, &request, &picture).unwrap().unwrap().pixels,
        None => picture.pixels,
    };
    pixels.iter().map(|pixel| pixel.to_le_bytes()).map(|[r, g, b, _]| [r, g, b]).collect()
}

/// The base color in the middle of each quarter: upper left, upper right, lower left, lower right.
fn quarters(loaded: &Loaded) -> [[u8; 3]; 4] {
    let pixels = seen(loaded, Some(DebugView::Albedo));
    [8, 24].map(|y| [8, 24].map(|x| pixels[32 * y + x])).as_flattened().try_into().unwrap()
}

/// A square over all of the picture with the material `t`, after these lines.
fn square(lines: &str) -> Vec<u8> {
    format!(
        "{lines}\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
         usemtl t\nf 1/1 2/2 3/3 4/4\n"
    )
    .into_bytes()
}

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];
const WHITE: [u8; 4] = [255; 4];

/// Red and green above blue and white, with so many texels a side in each quarter.
fn four_colors(side: usize) -> Vec<u8> {
    let row = |a, b| [[a].repeat(side), [b].repeat(side)].concat();
    png(2 * side as u32, &[row(RED, GREEN).repeat(side), row(BLUE, WHITE).repeat(side)].concat())
}

fn rgb([r, g, b, _]: [u8; 4]) -> [u8; 3] {
    [r, g, b]
}

#[test]
fn byte_order_marks_are_no_part_of_the_text() {
    let mark = |text: &[u8]| [b"\xef\xbb\xbf", text].concat();
    let obj = mark(&square("mtllib m.mtl"));
    let scene = loaded("bom", &[("a.obj", &obj), ("m.mtl", &mark(b"newmtl t\nKd 1 0 0\n"))]);
    assert_eq!(quarters(&scene), [rgb(RED); 4]);
    // The first line is a vertex.
    let text = mark(b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nf 1 2 3\n");
    assert_eq!(loaded("bom-nameless", &[("a", &text)]).scene.drawn_triangles(), 1);
    let scene = loaded("bom-v", &[("a.obj", &text)]);
    assert_eq!(scene.scene.positions().len(), 3);
}

#[test]
fn a_line_may_name_several_libraries() {
    let (a, b): (&[u8], &[u8]) = (b"newmtl other\nKd 0 0 0\n", b"newmtl t\nKd 0 1 0\n");
    for (number, names) in ["a.mtl b c.mtl", "b c.mtl a.mtl", "b c.mtl"].iter().enumerate() {
        let obj = square(&format!("mtllib {names}"));
        let scene = loaded(&format!("libraries-{number}"), &[("x.obj", &obj), ("a.mtl", a), ("b c.mtl", b)]);
        assert_eq!(quarters(&scene), [rgb(GREEN); 4], "{names}");
    }
    let obj = square("mtllib a.mtl gone.mtl");
    let files: [(&str, &[u8]); 2] = [("x.obj", &obj), ("a.mtl", a)];
    let scene = load(&folder("libraries-gone", &files).join("x.obj"), &Sequential).unwrap();
    assert!(scene.warnings[0].starts_with("material library \"gone.mtl\":"), "{:?}", scene.warnings);
}

#[test]
fn a_texture_lies_beside_its_library_or_beside_the_scene() {
    let obj = square("mtllib mats\\m.mtl");
    let red = png(1, &[RED]);
    for (number, (name, place)) in [
        ("t.png", "mats/t.png"),
        ("t.png", "t.png"),
        ("tex\\t.png", "mats/tex/t.png"),
        ("C:\\work\\my tex\\T.PNG", "mats/t.png"),
    ]
    .into_iter()
    .enumerate()
    {
        let mtl = format!("newmtl t\nKd 1 1 1\nmap_Kd {name}\n");
        let files: [(&str, &[u8]); 3] = [("x.obj", &obj), ("mats/m.mtl", mtl.as_bytes()), (place, &red)];
        assert_eq!(quarters(&loaded(&format!("paths-{number}"), &files)), [rgb(RED); 4], "{name}");
    }
}

#[test]
fn options_scale_and_move_a_texture() {
    let picture = four_colors(8);
    let with = |test: &str, options: &str| {
        let mtl = format!("newmtl t\nmap_Kd {options} four.png\n");
        loaded(test, &[("x.obj", &square("mtllib m.mtl")), ("m.mtl", mtl.as_bytes()), ("four.png", &picture)])
    };
    let [red, green, blue, white] = [RED, GREEN, BLUE, WHITE].map(rgb);
    assert_eq!(quarters(&with("options", "")), [red, green, blue, white]);
    // Half a picture to the left, or upward: columns or rows trade places.
    assert_eq!(quarters(&with("options-u", "-o 0.5 0 0")), [green, red, white, blue]);
    assert_eq!(quarters(&with("options-v", "-o 0 0.5 0")), [blue, white, red, green]);
    // A quarter of it has the whole picture: its own quarters are 8 pixels wide.
    let pixels = seen(&with("options-s", "-s 2 2 1"), Some(DebugView::Albedo));
    for (x, y, color) in
        [(4, 4, red), (12, 4, green), (4, 12, blue), (12, 12, white), (20, 4, red), (28, 28, white)]
    {
        assert_eq!(pixels[32 * y + x], color, "{x} {y}");
    }
    // (0.25, 0.75) of OBJ goes to 2 · 0.25 + 0.5 and 3 · 0.75 + 0.25; textures count rows from the top.
    let Texture { turn, shift, .. } =
        with("options-both", "-s 2 3 -o 0.5 0.25").scene.materials()[0].textures[0];
    let place = [0, 1].map(|i| turn[i][0] * 0.25 + turn[i][1] * 0.25 + shift[i]);
    assert_eq!(place, [1.0, 1.0 - 2.5]);
}

#[test]
fn alpha_comes_from_a_mask_or_from_the_texture() {
    let (obj, gray) = (square("mtllib m.mtl"), |a: u8| [a, a, a, 255]);
    let mask = png(2, &[gray(255), gray(0), gray(0), gray(255)]);
    let half = png(1, &[gray(128)]);
    let clear = png(2, &[[255, 0, 0, 255], [255, 0, 0, 0], [255, 0, 0, 0], [255, 0, 0, 255]]);
    let red = png(1, &[RED]);
    let cases: [(&str, &str, AlphaKind); 6] = [
        ("mask", "map_Kd red.png\nmap_d mask.png", AlphaKind::Mask),
        ("mask-alone", "Kd 1 0 0\nmap_d mask.png", AlphaKind::Mask),
        ("own", "map_Kd clear.png", AlphaKind::Mask),
        ("half", "map_Kd red.png\nmap_d half.png", AlphaKind::Blend),
        ("d", "d 0.5\nmap_Kd clear.png", AlphaKind::Blend),
        ("opaque", "map_Kd red.png", AlphaKind::Opaque),
    ];
    for (test, lines, mode) in cases {
        let mtl = format!("newmtl t\n{lines}\n");
        let files: [(&str, &[u8]); 6] = [
            ("x.obj", &obj),
            ("m.mtl", mtl.as_bytes()),
            ("mask.png", &mask),
            ("half.png", &half),
            ("clear.png", &clear),
            ("red.png", &red),
        ];
        let scene = loaded(&format!("alpha-{test}"), &files);
        assert_eq!(scene.scene.materials()[0].alpha_mode, mode as u32, "{test}");
        if mode == AlphaKind::Mask {
            let [a, b, c, d] = quarters(&scene);
            assert_eq!([a, d], [rgb(RED); 2], "{test}");
            assert_eq!([b, c], [[0; 3]; 2], "{test}");
        }
    }
}

#[test]
fn physically_based_keys_are_metalness_and_roughness() {
    let files = |mtl: &'static str| -> Loaded {
        let (obj, gray) = (square("mtllib m.mtl"), png(1, &[[128, 128, 128, 255]]));
        let normals = png(1, &[[128, 128, 255, 255]]);
        let files: [(&str, &[u8]); 4] =
            [("x.obj", &obj), ("m.mtl", mtl.as_bytes()), ("gray.png", &gray), ("normals.png", &normals)];
        let path = folder(&format!("physical-{}", mtl.len()), &files).join("x.obj");
        load(&path, &Sequential).unwrap()
    };
    let scene = files("newmtl t\nKd 1 1 1\nPr 0.25\nPm 1\nNs 900\nKs 1 1 1\n");
    let material = scene.scene.materials()[0];
    assert_eq!((material.roughness, material.metallic), (0.25, 1.0));
    let scene = files("newmtl t\nmap_Pr gray.png\nmap_Pm gray.png\nnorm normals.png\nmap_Ke gray.png\n");
    let material = scene.scene.materials()[0];
    assert_eq!((material.roughness, material.metallic, material.emission), (1.0, 1.0, [1.0; 3]));
    let has = |place: usize| material.textures[place].levels > 0;
    let maps = [
        MaterialRecord::COLOR,
        MaterialRecord::NORMAL,
        MaterialRecord::ROUGHNESS,
        MaterialRecord::OCCLUSION,
        MaterialRecord::EMISSION,
    ];
    assert_eq!(maps.map(has), [false, true, true, false, true]);
    let scene = files("newmtl t\nPr 0.5\nPc 0.75\nPcr 0.25\nPs 0.5\n");
    let material = scene.scene.materials()[0];
    assert_eq!((material.coat, material.coat_roughness, material.sheen), (0.75, 0.25, [0.5; 3]));
    let given = MaterialRecord::HAS_COAT | MaterialRecord::HAS_SHEEN;
    assert_eq!((material.extensions, scene.warnings.len()), (given, 0));
    // A normal map in place of heights, with its strength; then heights, which are named.
    let scene = files("newmtl t\nmap_Bump -bm 0.5 normals.png\n");
    assert_eq!((scene.scene.materials()[0].bump, scene.warnings.len()), (0.5, 0));
    let scene = files("newmtl t\nbump gray.png\nTf 0.5 0.5 0.5\nmap_Ks gray.png\n");
    assert_eq!(scene.warnings, ["not drawn: Tf of MTL, heights in map_Bump of MTL, map_Ks of MTL"]);
}

#[test]
fn colors_of_obj_are_srgb() {
    let corner = |x: i32, y: i32| format!("v {x} {y} 0 0.5 0.5 0.5\n");
    let obj = corner(-1, -1) + &corner(1, -1) + &corner(1, 1) + &corner(-1, 1) + "f 1 2 3 4\n";
    assert_eq!(quarters(&loaded("colors", &[("x.obj", obj.as_bytes())])), [[128; 3]; 4]);
    // A texture without `Kd` is as it is.
    let (obj, gray) = (square("mtllib m.mtl"), png(1, &[[128, 128, 128, 255]]));
    let files: [(&str, &[u8]); 3] =
        [("x.obj", &obj), ("m.mtl", b"newmtl t\nmap_Kd g.png\n"), ("g.png", &gray)];
    assert_eq!(quarters(&loaded("no-kd", &files)), [[128; 3]; 4]);
}

#[test]
fn numbers_that_are_not_finite_give_one_warning() {
    let obj = b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn nan 0 0\nvn -nan(ind) 0 0\nvt 1.#QNAN 0\n\
        f 1/1/1 2/1/2 3/1/1 4/1/2\n";
    let scene = load(&folder("nan", &[("x.obj", obj)]).join("x.obj"), &Sequential).unwrap();
    assert!(scene.warnings.len() == 1 && scene.warnings[0].starts_with("8 corners"), "{:?}", scene.warnings);
    assert!(scene.scene.attributes().iter().all(|a| a.normal == [0.0, 0.0, 1.0]));
}

/// A glTF file with these top-level members, whose first buffer has these bytes.
fn gltf(members: &str, bytes: &[u8]) -> Vec<u8> {
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!(
        r#"{{"asset":{{"version":"2.0"}},{members},
        "buffers":[{{"byteLength":{},"uri":"DATA:application/octet-stream;BASE64,{data}"}}]}}"#,
        bytes.len()
    )
    .into_bytes()
}

/// The bytes of these numbers.
fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// Two triangles without symmetry, facing +z.
const CORNERS: [f32; 18] = [
    -0.75, -0.5, 0.0, 0.5, -0.5, 0.0, 0.5, 0.75, 0.0, //
    -0.75, 0.0, 0.5, -0.25, 0.0, 0.0, -0.75, 0.75, 0.0,
];

#[test]
fn channels_without_a_target_node_are_ignored() {
    let bytes = [floats(&CORNERS), floats(&[0.0, 1.0]), floats(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0])].concat();
    let members = |target: &str| {
        format!(
            r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":6}},
            {{"bufferView":0,"byteOffset":72,"componentType":5126,"type":"SCALAR","count":2}},
            {{"bufferView":0,"byteOffset":80,"componentType":5126,"type":"VEC3","count":2}}],
            "animations":[{{"samplers":[{{"input":1,"output":2}}],"channels":[
            {{"sampler":0,"target":{target}}},{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}]}}],
            "bufferViews":[{{"buffer":0,"byteLength":104}}]"#
        )
    };
    for (number, target) in [
        r#"{"path":"scale"}"#,
        r#"{"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":"/nodes/0/scale"}}}"#,
    ]
    .into_iter()
    .enumerate()
    {
        let file = gltf(&members(target), &bytes);
        let name = format!("channels-{number}");
        let loaded = load(&folder(&name, &[("x.gltf", &file)]).join("x.gltf"), &Sequential).unwrap();
        assert_eq!(loaded.warnings, ["1 animation channels without a target node are ignored"]);
        let pose = loaded.animation.unwrap().at(0.5).unwrap();
        assert_eq!(pose.objects[0].1.w_axis.truncate(), Vec3::X);
    }
}

#[test]
fn scenes_need_no_nodes() {
    let scenes = r#""scene":0,"scenes":[{"nodes":[0]},{"name":"empty"}]"#;
    let mesh = r#""nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":6}],
        "bufferViews":[{"buffer":0,"byteLength":72}]"#;
    let file = gltf(&format!("{scenes},{mesh}"), &floats(&CORNERS));
    assert_eq!(loaded("scenes", &[("x.gltf", &file)]).scene.drawn_triangles(), 2);
}

/// The triangles as a skin under an armature with these transforms of its joints, `sets` of four joints a vertex, or
/// without a skin under a node with the first transform.
fn skinned(armature: &str, joints: &[&str], sets: usize, is_skinned: bool) -> Vec<u8> {
    let first = joints.len();
    let children: Vec<String> = (1..=first).map(|node| node.to_string()).collect();
    let joint_nodes: Vec<String> = joints.iter().map(|joint| format!("{{{joint}}}")).collect();
    let mut bytes = floats(&CORNERS);
    let mut attributes = r#""POSITION":0"#.to_owned();
    let mut accessors = r#"{"bufferView":0,"componentType":5126,"type":"VEC3","count":6}"#.to_owned();
    for set in (0..sets).filter(|_| is_skinned) {
        let (joints_at, weight) = (bytes.len(), 1.0 / joints.len() as f32);
        let used = |k: usize| 4 * set + k < joints.len();
        let row: Vec<u8> = (0..4).map(|k| if used(k) { (4 * set + k) as u8 } else { 0 }).collect();
        bytes.extend(row.repeat(6));
        let weights_at = bytes.len();
        let row: Vec<f32> = (0..4).map(|k| if used(k) { weight } else { 0.0 }).collect();
        bytes.extend(floats(&row.repeat(6)));
        let next = 1 + 2 * set;
        attributes += &format!(r#","JOINTS_{set}":{next},"WEIGHTS_{set}":{}"#, next + 1);
        for (at, kind) in [(joints_at, 5121), (weights_at, 5126)] {
            accessors += &format!(
                r#",{{"bufferView":0,"byteOffset":{at},"componentType":{kind},"type":"VEC4","count":6}}"#
            );
        }
    }
    let mesh_node = if is_skinned { r#"{"mesh":0,"skin":0}"# } else { r#"{"mesh":0}"# };
    let (roots, armature_children) = if is_skinned {
        (format!("0,{}", first + 1), children.join(","))
    } else {
        ("0".to_owned(), (first + 1).to_string())
    };
    let members = format!(
        r#""scene":0,"scenes":[{{"nodes":[{roots}]}}],
        "nodes":[{{{armature}"children":[{armature_children}]}},{},{mesh_node}],
        "skins":[{{"joints":[{}]}}],"meshes":[{{"primitives":[{{"attributes":{{{attributes}}}}}]}}],
        "accessors":[{accessors}],"bufferViews":[{{"buffer":0,"byteLength":{}}}]"#,
        joint_nodes.join(","),
        children.join(","),
        bytes.len()
    );
    gltf(&members, &bytes)
}

#[test]
fn a_vertex_may_hang_on_eight_joints() {
    let (rest, moved) = (r#""translation":[0,0,0]"#, r#""translation":[4,0,0]"#);
    let joints = [rest, rest, rest, rest, moved, moved, moved, moved];
    let scene = loaded("joints", &[("x.gltf", &skinned("", &joints, 2, true))]).scene;
    let (low, high) = scene.extent().unwrap();
    // Half of the weight moves by 4.
    assert_eq!((low.x, high.x), (-0.75 + 2.0, 0.5 + 2.0));
}

#[test]
fn a_mirrored_skin_is_the_mesh_under_the_mirrored_node() {
    for (number, armature) in ["", r#""scale":[-1,1,1],"#, r#""scale":[1,-1,1],"#].into_iter().enumerate() {
        let pictures = [true, false].map(|is_skinned| {
            let file = skinned(armature, &[r#""name":"joint""#], 1, is_skinned);
            let scene = loaded(&format!("mirrored-{number}-{is_skinned}"), &[("x.gltf", &file)]);
            (seen(&scene, None), seen(&scene, Some(DebugView::Normal)))
        });
        assert!(pictures[0] == pictures[1], "{armature}");
        assert!(pictures[0].0.iter().any(|pixel| *pixel != pictures[0].0[0]), "{armature} shows nothing");
    }
}

#[test]
fn cameras_have_the_shape_of_their_picture() {
    let members = r#""nodes":[{"camera":0,"translation":[0,0,5]},{"camera":1,"translation":[0,0,5]}],
        "cameras":[{"type":"orthographic","orthographic":{"xmag":2.4,"ymag":1,"znear":0,"zfar":9}},
        {"type":"perspective","perspective":{"aspectRatio":2,"yfov":1.5707963267948966,"znear":0.1}}]"#;
    let cameras = loaded("cameras", &[("x.gltf", &gltf(members, &[0; 4]))]).cameras;
    let Projection::Orthographic { height } = cameras[0].fitted(1.2).projection else { panic!() };
    assert!((height - 4.0).abs() < 1e-6, "{height}");
    // tan(45°) · 2 / 1: twice as high as wide needs an angle of 2 · atan 2.
    let Projection::Perspective { fov_y } = cameras[1].fitted(1.0).projection else { panic!() };
    assert!((fov_y - 2.0 * 2.0_f32.atan()).abs() < 1e-6, "{fov_y}");
    assert_eq!(cameras[1].fitted(2.5), cameras[1].camera);
    assert_eq!([cameras[0].clip, cameras[1].clip], [[0.0, 9.0], [0.1, f32::INFINITY]]);
}

#[test]
fn clip_planes_in_a_wrong_order_are_ignored_with_a_warning() {
    let members = r#""nodes":[{"camera":0}],
        "cameras":[{"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"znear":2,"zfar":1}}]"#;
    let path = folder("planes", &[("x.gltf", &gltf(members, &[0; 4]))]).join("x.gltf");
    let loaded = load(&path, &Sequential).unwrap();
    assert_eq!(loaded.cameras[0].clip, [0.0, f32::INFINITY]);
    assert_eq!(loaded.warnings, ["the clip planes of the camera of node 0 are ignored: 2 and 1"]);
}

/// A square on two nodes, a lamp and a camera, under a node at this place; with `more`, one more square at the origin of
/// coordinates.
fn under_a_node(place: [f64; 3], more: bool) -> Vec<u8> {
    let nodes = if more { "0,6" } else { "0" };
    let members = format!(
        r#""extensionsUsed":["KHR_lights_punctual"],"extensions":{{"KHR_lights_punctual":{{"lights":[
        {{"type":"point","intensity":30}}]}}}},"scenes":[{{"nodes":[{nodes}]}}],
        "nodes":[{{"translation":{place:?},"children":[1,2,3,4,5]}},{{"mesh":0}},
        {{"mesh":0,"translation":[0.3,0.1,0.4],"scale":[0.2,0.3,1]}},{{"camera":0,"translation":[0.7,0.2,3]}},
        {{"translation":[1.3,0.9,2.1],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}},
        {{"mesh":0,"translation":[-0.4,0,0.2],"scale":[0.1,0.1,0.1],"rotation":[0.6,0,0,0.8]}},{{"mesh":0}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":0.9,"znear":0.01}}}}],
        "materials":[{{"doubleSided":true}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":6,
        "min":[-1,-1,0],"max":[1,1,0]}}],"bufferViews":[{{"buffer":0,"byteLength":72}}]"#
    );
    gltf(&members, &floats(&CORNERS))
}

#[test]
fn what_is_far_from_the_origin_is_drawn_as_if_it_were_near() {
    let far = [6e6, 0.0, -4e6];
    // All of the scene, or what the camera is beside.
    let places = [([0.0; 3], false), (far, false), ([-6_000_000.5, 3e5, 1e7], false), (far, true)];
    let pictures = places.map(|(place, more)| {
        let loaded = loaded(&format!("far-{}{more}", place[0]), &[("x.gltf", &under_a_node(place, more))]);
        assert!((loaded.origin - glam::DVec3::from(place)).abs().max_element() < 3.3, "{}", loaded.origin);
        let request = Request::new(&loaded.cameras[0].camera, [48, 32]).shadows(Shadows::Hard);
        let mut picture = Picture::default();
        let mut cpu = Cpu::new(Options { lanes: Some(1), threads: Some(1) }).unwrap();
        cpu.render(&loaded.scene, &request, &mut picture).unwrap();
        picture.pixels
    });
    let colors: std::collections::BTreeSet<_> = pictures[0].iter().collect();
    assert!(colors.len() > 30, "{} colors", colors.len());
    for far in &pictures[1..] {
        let differs = far.iter().zip(&pictures[0]).filter(|(far, near)| far != near).count();
        assert!(differs * 100 <= far.len(), "{differs} of {}", far.len());
    }
}

#[test]
fn digits_of_far_vertices_count() {
    let corners = [[0.1, 0.2, 0.0], [1.3, 0.0, 0.0], [0.0, 1.7, 0.4]];
    let origin = glam::DVec3::new(6e6, 0.0, -4e6);
    let text = |far: glam::DVec3, line: &dyn Fn([f64; 3]) -> String| -> String {
        corners.iter().map(|corner| line((glam::DVec3::from(*corner) + far).into())).collect()
    };
    let obj = |far| format!("{}f 1 2 3\n", text(far, &|[x, y, z]| format!("v {x} {y} {z}\n")));
    let ply = |far| {
        let kinds = "property double x\nproperty double y\nproperty double z\n";
        let faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        let vertices = text(far, &|[x, y, z]| format!("{x} {y} {z}\n"));
        format!("ply\nformat ascii 1.0\nelement vertex 3\n{kinds}{faces}{vertices}3 0 1 2\n")
    };
    for (name, write) in [("x.obj", &obj as &dyn Fn(glam::DVec3) -> String), ("x.ply", &ply)] {
        let [near, far] =
            [glam::DVec3::ZERO, origin].map(|far| loaded("digits", &[(name, write(far).as_bytes())]));
        assert_eq!([near.origin, far.origin], [glam::DVec3::ZERO, origin], "{name}");
        for (near, far) in near.scene.positions().iter().zip(far.scene.positions()) {
            let apart = (Vec3::from(*near) - Vec3::from(*far)).abs().max_element();
            // 2⁻³⁰ is double precision at 6,000,000.
            assert!(apart < 3e-8 + 1.0 / 1_073_741_824.0, "{name}: {near:?} {far:?}");
        }
    }
}

#[test]
fn coarse_vertices_are_named() {
    let far: Vec<f32> = (0..18).map(|i| CORNERS[i] + if i % 3 == 0 { 6e6 } else { 0.0 }).collect();
    let members = r#""nodes":[{"mesh":0}],"meshes":[{"name":"m","primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":6}],
        "bufferViews":[{"buffer":0,"byteLength":72}]"#;
    let file = gltf(members, &floats(&far));
    let path = folder("coarse", &[("x.gltf", &file)]).join("x.gltf");
    let warnings = load(&path, &Sequential).unwrap().warnings;
    assert!(
        warnings.iter().any(|line| line.contains("numbers are 0.5 apart, 1/4 of its size")),
        "{warnings:?}"
    );
}

#[test]
fn specular_glossiness_has_a_diffuse_color_and_a_highlight() {
    let members = r#""extensionsUsed":["KHR_materials_pbrSpecularGlossiness"],"nodes":[{"mesh":0}],
        "materials":[{"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0.8,0.1,0.1,1],
        "specularFactor":[0.5,0.25,0],"glossinessFactor":0.75}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":6}],
        "bufferViews":[{"buffer":0,"byteLength":72}]"#;
    let scene = loaded("glossy", &[("x.gltf", &gltf(members, &floats(&CORNERS)))]).scene;
    let material = scene.materials()[0];
    assert_eq!((material.base, material.specular), ([0.8, 0.1, 0.1], [0.5, 0.25, 0.0]));
    assert_eq!((material.roughness, material.metallic), (0.25, 0.0));
}

/// The record of a material of a glTF file with a texture, and the warnings.
fn extended(test: &str, material: &str) -> (MaterialRecord, Vec<String>) {
    let image = png(1, &[[255, 128, 64, 128]]);
    let members = format!(
        r#""nodes":[{{"mesh":0}}],"materials":[{material}],"textures":[{{"source":0}}],"images":[{{"uri":"t.png"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":6}}],
        "bufferViews":[{{"buffer":0,"byteLength":72}}]"#
    );
    let file = gltf(&members, &floats(&CORNERS));
    let path = folder(test, &[("x.gltf", &file), ("t.png", &image)]).join("x.gltf");
    let loaded = load(&path, &Sequential).unwrap();
    (loaded.scene.materials()[0], loaded.warnings)
}

#[test]
fn extensions_of_materials_are_read() {
    let of = |name: &str, properties: &str| {
        let (material, warnings) =
            extended(name, &format!(r#"{{"extensions":{{"KHR_materials_{name}":{{{properties}}}}}}}"#));
        assert_eq!(warnings, [""; 0], "{name}");
        material
    };
    let has = |material: &MaterialRecord, maps: &[usize]| {
        (5..MaterialRecord::TEXTURES).all(|map| (material.textures[map].levels > 0) == maps.contains(&map))
    };
    let none = of("ior", "");
    assert_eq!((none.extensions, none.strength), (0, 1.0));
    assert!(none.specular.iter().all(|share| (share - 0.04).abs() < 1e-8), "{:?}", none.specular);
    assert_eq!(of("ior", r#""ior":3"#).specular, [0.25; 3]);
    // 0 stands for what mirrors everything.
    assert_eq!(of("ior", r#""ior":0"#).specular, [1.0; 3]);
    let m =
        of("specular", r#""specularFactor":0.5,"specularColorFactor":[2,1,0],"specularTexture":{"index":0}"#);
    assert_eq!(
        (m.strength, m.specular, m.extensions),
        (0.5, [0.08, 0.04, 0.0], MaterialRecord::SPECULAR_MAPS)
    );
    assert!(has(&m, &[MaterialRecord::SPECULAR]));
    let m = of(
        "clearcoat",
        r#""clearcoatFactor":0.75,"clearcoatRoughnessFactor":0.25,"clearcoatRoughnessTexture":{"index":0},
        "clearcoatNormalTexture":{"index":0,"scale":0.5}"#,
    );
    assert_eq!((m.coat, m.coat_roughness, m.coat_bump), (0.75, 0.25, 0.5));
    assert_eq!(m.extensions, MaterialRecord::HAS_COAT);
    assert!(has(&m, &[MaterialRecord::COAT_ROUGHNESS, MaterialRecord::COAT_NORMAL]));
    assert_eq!(of("clearcoat", r#""clearcoatRoughnessFactor":0.25"#).extensions, 0);
    let m = of(
        "sheen",
        r#""sheenColorFactor":[1,0.5,0],"sheenRoughnessFactor":0.5,"sheenColorTexture":{"index":0}"#,
    );
    assert_eq!((m.sheen, m.sheen_roughness, m.extensions), ([1.0, 0.5, 0.0], 0.5, MaterialRecord::HAS_SHEEN));
    assert!(has(&m, &[MaterialRecord::SHEEN]));
    let m = of(
        "anisotropy",
        r#""anisotropyStrength":0.5,"anisotropyRotation":0,"anisotropyTexture":{"index":0}"#,
    );
    assert_eq!((m.brushed, m.brushed_turn, m.extensions), (0.5, [1.0, 0.0], MaterialRecord::IS_BRUSHED));
    assert!(has(&m, &[MaterialRecord::BRUSHED]));
    let m = of(
        "iridescence",
        r#""iridescenceFactor":1,"iridescenceIor":1.5,"iridescenceThicknessTexture":{"index":0}"#,
    );
    assert_eq!((m.film, m.film_ior, m.film_thickness), (1.0, 1.5, [100.0, 400.0]));
    assert_eq!(m.extensions, MaterialRecord::HAS_FILM);
    assert!(has(&m, &[MaterialRecord::FILM_THICKNESS]));
    let m = of("pbrSpecularGlossiness", r#""glossinessFactor":0.5,"specularGlossinessTexture":{"index":0}"#);
    assert_eq!((m.roughness, m.metallic, m.strength), (1.0, 0.0, 1.0));
    assert!(has(&m, &[MaterialRecord::SPECULAR_COLOR]) && m.textures[MaterialRecord::ROUGHNESS].levels > 0);
}

#[test]
fn glass_says_what_of_it_is_approximated() {
    let glass = |more: &str| {
        let transmission = r#""KHR_materials_transmission":{"transmissionFactor":0.5}"#;
        let pbr = r#""pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":"#;
        extended("glass", &format!(r#"{{{pbr}{more},{transmission}}}}}"#))
    };
    let (material, warnings) = glass(r#"0},"extensions":{"KHR_materials_ior":{"ior":1.5}"#);
    assert_eq!((material.transmission, warnings.len()), (0.5, 0));
    assert_eq!(material.extensions, MaterialRecord::TRANSMITS | MaterialRecord::IGNORES_ALPHA);
    assert_eq!((material.refraction, material.double_sided), (1.0, 0));
    let volume = r#"0.5},"extensions":{"KHR_materials_volume":{"thicknessFactor":1}"#;
    let (material, warnings) = glass(&format!(r#"{volume},"KHR_materials_ior":{{"ior":1.25}}"#));
    let refraction = "refraction of what is behind glass, but for the environment";
    let blur = "the blur of what is behind rough glass, but for the environment";
    assert_eq!(warnings, [format!("not drawn: {refraction}, {blur}")]);
    // Rays meet both sides of a body.
    assert_eq!((material.refraction, material.double_sided), (1.25, 1));
    assert_eq!(glass(volume).0.refraction, 1.5);
    // Also where they do not turn light.
    let (material, _) = glass(&format!(r#"{volume},"KHR_materials_ior":{{"ior":1}}"#));
    assert_eq!((material.refraction, material.double_sided), (1.0, 1));
    let deflects = |material: &MaterialRecord| material.extensions & MaterialRecord::DEFLECTS != 0;
    assert!(
        deflects(&material) && deflects(&glass(r#"0.5},"extensions":{"KHR_materials_ior":{"ior":1.5}"#).0)
    );
}

#[test]
fn glowing_surfaces_light_nothing_and_a_warning_says_so() {
    let (material, warnings) = extended("glow", r#"{"emissiveFactor":[1,0.5,0]}"#);
    assert_eq!(material.emission, [1.0, 0.5, 0.0]);
    assert_eq!(warnings, ["not drawn: the light that glowing surfaces shed"]);
}

/// A floor below a square that glows downward, as large as this share of it.
fn lit_room(side: f32, emission: &str) -> Loaded {
    let half = side * 0.5;
    let floor =
        [-1.0, 0.0, -1.0, -1.0, 0.0, 1.0, 1.0, 0.0, 1.0, -1.0, 0.0, -1.0, 1.0, 0.0, 1.0, 1.0, 0.0, -1.0];
    let [a, b, c, d] = [[-half, 1.5, -half], [half, 1.5, -half], [half, 1.5, half], [-half, 1.5, half]];
    let lamp: Vec<f32> = [a, b, c, a, c, d].concat();
    let members = format!(
        r#""nodes":[{{"mesh":0}},{{"mesh":1}}],"materials":[{{}},{{"emissiveFactor":{emission}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}},
        {{"primitives":[{{"attributes":{{"POSITION":1}},"material":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":6}},
        {{"bufferView":1,"componentType":5126,"type":"VEC3","count":6}}],
        "bufferViews":[{{"buffer":0,"byteLength":72}},{{"buffer":0,"byteOffset":72,"byteLength":72}}]"#
    );
    let file = gltf(&members, &[floats(&floor), floats(&lamp)].concat());
    load(&folder(&format!("lamp-{side}"), &[("x.gltf", &file)]).join("x.gltf"), &Sequential).unwrap()
}

#[test]
fn a_large_flat_surface_that_glows_lights_the_scene() {
    let loaded = lit_room(0.5, "[1,0.5,0]");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let [lamp] = loaded.scene.lights() else { panic!("{:?}", loaded.scene.lights()) };
    // 3/2 · 0.5² · emission, from the middle of the square, which faces down.
    assert!((lamp.color - Vec3::new(0.375, 0.1875, 0.0)).abs().max_element() < 1e-6, "{}", lamp.color);
    assert!(lamp.position.distance(Vec3::new(0.0, 1.4995, 0.0)) < 1e-6, "{}", lamp.position);
    assert!(lamp.direction.distance(-Vec3::Y) < 1e-6 && lamp.inverse_square, "{}", lamp.direction);
    assert!((lamp.radius - (0.25 / std::f32::consts::PI).sqrt()).abs() < 1e-6, "{}", lamp.radius);
    let small = lit_room(0.02, "[1,1,1]");
    assert_eq!((small.scene.lights().len(), small.warnings.len()), (0, 1));
}

#[test]
fn zeros_after_the_json_of_a_binary_file_are_padding() {
    let json = br#"{"asset":{"version":"2.0"}}"#;
    let length = (json.len() as u32).next_multiple_of(4);
    let mut file = b"glTF".to_vec();
    for word in [2, 20 + length, length, u32::from_le_bytes(*b"JSON")] {
        file.extend(word.to_le_bytes());
    }
    file.extend(json);
    file.resize(20 + length as usize, 0);
    assert_eq!(loaded("padding", &[("x.glb", &file)]).scene.drawn_triangles(), 0);
    // Binary glTF is what it is, whatever its name ends in.
    for name in ["x.obj", "x.stl", "x.gltf", "x"] {
        assert_eq!(loaded("padding", &[(name, &file)]).scene.drawn_triangles(), 0, "{name}");
    }
    // And text that begins so is neither OBJ nor PLY.
    for name in ["x.obj", "x.ply"] {
        assert_eq!(loaded("padding", &[(name, json)]).scene.drawn_triangles(), 0, "{name}");
    }
}

#[test]
fn a_file_that_is_no_gltf_is_refused_in_words() {
    for name in ["x.glb", "x.gltf"] {
        let folder = folder("no_gltf", &[(name, b"\x89PNG\r\n\x1a\n")]);
        let said = load(&folder.join(name), &Sequential).err().unwrap().to_string();
        assert!(said.ends_with("it begins neither as JSON does ({) nor as binary glTF (glTF)"), "{said}");
    }
}

/// A white triangle around the origin, facing +z, a triangle somewhere else, and a lamp of 2 candela, and of 6 in
/// red, 4 above the origin.
fn lamp(size: f32, elsewhere: [f32; 3]) -> Vec<u8> {
    let [x, y, z] = elsewhere;
    let corners = [
        [-3.0 * size, -size, 0.0, 3.0 * size, -size, 0.0, 0.0, 2.0 * size, 0.0],
        [x, y, z, x + 1.0, y, z, x, y + 1.0, z],
    ];
    let members = r#""nodes":[{"mesh":0},
        {"translation":[0,0,4],"extensions":{"KHR_lights_punctual":{"light":0}}}],
        "extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[
        {"type":"point","color":[1,0.33333334,0.33333334],"intensity":6}]}},
        "materials":[{"pbrMetallicRoughness":{"metallicFactor":0}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":6}],
        "bufferViews":[{"buffer":0,"byteLength":72}]"#;
    gltf(members, &floats(corners.as_flattened()))
}

#[test]
fn a_lamp_is_as_bright_as_the_file_says_whatever_else_is_in_the_scene() {
    let cases = [
        (6.0, [0.0, 0.0, -9.0]),
        (15.0, [0.0, 0.0, -9.0]),
        (60.0, [0.0, 0.0, -9.0]),
        (6.0, [9e4, -7e3, 3e2]),
    ];
    let mut pictures = cases.iter().zip(0..).map(|(&(size, elsewhere), number)| {
        let loaded = loaded(&format!("lamp-{number}"), &[("x.gltf", &lamp(size, elsewhere))]);
        let [light] = loaded.scene.lights() else { panic!("one light") };
        assert_eq!((light.color, light.inverse_square, light.reach), (Vec3::new(6.0, 2.0, 2.0), true, None));
        seen(&loaded, None)
    });
    let first = pictures.next().unwrap();
    assert!(pictures.all(|picture| picture == first));
    // Under the lamp it is brighter than at the edge, and nowhere white.
    let [middle, edge] = [first[32 * 16 + 16], first[16]];
    assert!(edge[0] < middle[0] && middle[1] < middle[0] && middle[0] < 255, "{edge:?} {middle:?}");
}

#[test]
fn the_color_of_transparent_texels_colors_nothing() {
    // Columns of green, and of what is not seen, 16 of them in each pixel.
    let picture = |hidden: [u8; 4]| {
        let texels: Vec<_> = (0..512 * 2).map(|i| if i % 2 == 0 { GREEN } else { hidden }).collect();
        let data = base64::engine::general_purpose::STANDARD.encode(png(512, &texels));
        let members = format!(
            r#""nodes":[{{"mesh":0}}],"images":[{{"uri":"data:image/png;base64,{data}"}}],"textures":[{{"source":0}}],
            "materials":[{{"alphaMode":"BLEND","extensions":{{"KHR_materials_unlit":{{}}}},
            "pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],"extensionsUsed":["KHR_materials_unlit"],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}},
            {{"bufferView":0,"byteOffset":36,"componentType":5126,"type":"VEC2","count":3}}],
            "bufferViews":[{{"buffer":0,"byteLength":60}}]"#
        );
        let corners = [-1.0, -1.0, 0.0, 3.0, -1.0, 0.0, -1.0, 3.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0];
        let name = format!("hidden-{}", hidden[0]);
        let mut loaded = loaded(&name, &[("x.gltf", &gltf(&members, &floats(&corners)))]);
        loaded.scene.background = Vec3::ONE;
        seen(&loaded, None)
    };
    let pictures = [[0; 4], [0, 255, 0, 0], [255, 0, 255, 0]].map(picture);
    // Half of white, in linear light, behind half of green.
    assert!(pictures.iter().flatten().all(|pixel| *pixel == [188, 255, 188]), "{:?}", pictures[0][99]);
}

#[test]
fn samplers_choose_the_nearest_texel() {
    let corners = [-1.0, -1.0, 0.0, 3.0, -1.0, 0.0, -1.0, 3.0, 0.0, 0.0, 1.0, 2.0, 1.0, 0.0, -1.0];
    let data = base64::engine::general_purpose::STANDARD.encode(four_colors(1));
    let pixels = |sampler: &str| {
        let members = format!(
            r#""nodes":[{{"mesh":0}}],"images":[{{"uri":"data:image/png;base64,{data}"}}],
            "textures":[{{"source":0,"sampler":0}}],"samplers":[{{{sampler}"wrapS":33071,"wrapT":33071}}],
            "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}},
            {{"bufferView":0,"byteOffset":36,"componentType":5126,"type":"VEC2","count":3}}],
            "bufferViews":[{{"buffer":0,"byteLength":60}}]"#
        );
        let name = format!("nearest-{}", sampler.len());
        seen(&loaded(&name, &[("x.gltf", &gltf(&members, &floats(&corners)))]), Some(DebugView::Albedo))
    };
    let quarters = [[RED, GREEN], [BLUE, WHITE]];
    for (number, pixel) in pixels(r#""magFilter":9728,"#).into_iter().enumerate() {
        let [x, y] = [number % 32, number / 32].map(|place| usize::from(place >= 16));
        assert_eq!(pixel, rgb(quarters[y][x]), "{number}");
    }
    // Two texels over 32 pixels are magnified: the other filter does not count.
    for linear in ["", r#""magFilter":9729,"minFilter":9728,"#] {
        let mixed = pixels(linear);
        assert!(mixed[16 * 32 + 16] != rgb(WHITE) && mixed[16 * 32 + 16][1] > 0, "{:?}", mixed[16 * 32 + 16]);
    }
}
