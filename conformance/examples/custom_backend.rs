//! A backend of somebody else's: one thread, one ray after another, through the stages of `rtrt-core`. It passes
//! the conformance suite.
//!
//! ```text
//! $ cargo run --release -p conformance --example custom_backend
//! 141 cases on one ray after another: 0 differ
//! ```
//!
//! A backend decides where and when the stages run; what they compute is theirs. This one keeps nothing between
//! frames, and is as slow as it is short.

use bytemuck::Zeroable;
use conformance::{Suite, cases};
use rtrt_core::backend::{Backend, Deferred, Description, Picture, RenderError, Request};
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::lists::{Entry, Lists};
use rtrt_core::kernel::texture::Maps;
use rtrt_core::kernel::traverse::{Best, Geometry};
use rtrt_core::lane::Word;
use rtrt_core::layout::{Frame, Hit};
use rtrt_core::scene::{Scene, Setup};
use rtrt_core::stage::surface::{Surfaces, Vertices};
use rtrt_core::stage::visibility::{hit, rays, visibility};
use rtrt_core::stage::{bin, detail, layers, light, occlusion, prepare, resolve, shade, surface};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut backend = OneByOne::default();
    let outcome = Suite::new(cases::all()).run(&mut backend)?;
    for failed in &outcome.failures {
        println!("{}: {}", failed.case.name, failed.failure);
    }
    let (cases, differ) = (outcome.cases, outcome.failures.len());
    println!("{cases} cases on {}: {differ} differ", backend.describe().adapter);
    assert_eq!(differ, 0);
    Ok(())
}

/// The backend.
#[derive(Default)]
struct OneByOne {
    setup: Setup,
}

impl Backend for OneByOne {
    fn describe(&self) -> Description {
        let (kind, adapter) = ("one by one".into(), "one ray after another".into());
        Description { kind, adapter, lanes: 1, threads: 1 }
    }

    fn render(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        let &Request { camera, size, samples, shadows, layers, deferred } = request;
        self.setup.prepare(scene, camera, size, samples, shadows, layers)?;
        let frame = &self.setup.frame;
        let grid = frame.grid();
        let words = lists(&self.setup, scene);
        let mut kept = room(frame);
        for ray in 0..frame.rays {
            trace(&self.setup, scene, &words, ray, &mut kept);
        }
        let pixel = |number: u32| {
            let color = |ray: RayIndex| kept.colors[ray.0 as usize];
            resolve::resolve::<f32>((), grid, |_| grid.pixel(number), color).0
        };
        picture.pixels = (0..size[0] * size[1]).map(pixel).collect();
        [picture.width, picture.height] = size;
        kept.lists = words;
        picture.deferred = deferred.then_some(kept);
        Ok(())
    }
}

/// Buffers for a frame in which nothing has been hit.
fn room(frame: &Frame) -> Deferred {
    let rays = frame.rays as usize;
    let tint_words = if frame.layers == 0 { 0 } else { frame.lights };
    let layer_count = frame.layers.max(1) - 1;
    Deferred {
        lists: vec![],
        hits: vec![Hit::MISS; rays],
        surfaces: vec![Zeroable::zeroed(); rays],
        masks: vec![0; rays * frame.mask_words as usize],
        tints: vec![0; rays * tint_words as usize],
        lit: vec![Zeroable::zeroed(); rays],
        colors: vec![[0.0; 4]; rays],
        layers: vec![Hit::MISS; rays * layer_count as usize],
        mask_words: frame.mask_words,
        layer_count,
        tint_words,
    }
}

/// The stages `prepare` and `bin`: the lists of all blocks, each in the order of `(key, object)`.
fn lists(setup: &Setup, scene: &Scene) -> Vec<u32> {
    let (frame, views, objects) = (&setup.frame, &setup.views[..], scene.objects());
    let count = prepare::count(frame);
    let covers: Vec<_> = (0..count).map(|i| prepare::prepare(frame, views, objects, i)).collect();
    let mut blocks: Vec<Vec<Entry>> = vec![vec![]; frame.blocks as usize];
    for index in 0..count {
        bin::each_block(frame, views, objects, &covers, index, |block, entry| {
            blocks[block as usize].push(entry);
        });
    }
    let mut words = vec![0];
    for block in &mut blocks {
        block.sort_by_key(|entry| (entry.key, entry.object));
        words.push(words[words.len() - 1] + block.len() as u32);
    }
    words.extend(blocks.iter().flatten().flat_map(|entry| [entry.key, entry.object]));
    words
}

/// The stages from `visibility` to `layers`, for one ray.
fn trace(setup: &Setup, scene: &Scene, words: &[u32], ray: u32, kept: &mut Deferred) {
    let (mut frame, views) = (setup.frame, &setup.views[..]);
    let (lists, at, number) = (Lists { words, blocks: frame.blocks }, ray as usize, RayIndex(ray));
    let geometry = Geometry {
        objects: scene.objects(),
        nodes: scene.nodes(),
        words: scene.words(),
        positions: scene.positions(),
        texels: scene.texels(),
        magnitude: frame.magnitude,
    };
    let maps = Maps { materials: scene.materials(), texels: scene.texels() };
    let (objects, words, attributes) = (scene.objects(), scene.words(), scene.attributes());
    let vertices = Vertices { objects, words, attributes };
    let camera = &views[Frame::CAMERA as usize];
    let [primary] = rays::<f32, 1>((), &frame, camera, number);
    // A hit at 0 says that nothing has been looked for yet.
    let mut best = [Best::new(&Hit::zeroed())];
    let mut sum = [0.0; 4];
    for layer in 0.. {
        best = if frame.layers == 0 {
            visibility::<f32, 1>((), &frame, views, &lists, &geometry, number)
        } else {
            layers::layer::<f32, 1>((), &frame, views, &lists, &geometry, number, &best)
        };
        let mut found = surface::surface(camera, &geometry, attributes, &primary, &best[0]);
        if frame.details == 1 {
            found = detail::detail(&maps, &vertices, &best[0], &found);
        }
        let (masks, tints) = shadows(&frame, setup, &lists, &geometry, found);
        let (mask, tint) = (|word: u32| Word(masks[word as usize]), |light: u32| Word(tints[light as usize]));
        let arriving = light::light(&frame, views, &maps, mask, tint, &primary, &found);
        let shaded = shade::shade(&frame, &maps, &primary, &found, &arriving);
        sum = if frame.layers == 0 { shaded } else { layers::blend(&frame, sum, shaded) };
        if layer == 0 {
            kept.hits[at] = hit(&best[0], 0);
            kept.surfaces[at] = found.lane(0);
            kept.masks[at * masks.len()..][..masks.len()].copy_from_slice(&masks);
            kept.tints[at * tints.len()..][..tints.len()].copy_from_slice(&tints);
            kept.lit[at] = arriving.lane(0);
        } else {
            kept.layers[at * kept.layer_count as usize + layer - 1] = hit(&best[0], 0);
        }
        // The last layer counts as opaque, and what nothing shines through hides the others.
        if frame.layers <= 1 || layers::is_covered(sum[3]) || hit(&best[0], 0) == Hit::MISS {
            break;
        }
        frame.layers -= 1;
    }
    kept.colors[at] = sum;
}

/// The stage `occlusion`: the words of the shadow mask, and what is left of each light if not everything is
/// opaque.
fn shadows(
    frame: &Frame,
    setup: &Setup,
    lists: &Lists<'_>,
    geometry: &Geometry<'_>,
    found: Surfaces<f32>,
) -> (Vec<u32>, Vec<u32>) {
    let views = &setup.views[..];
    if frame.layers == 0 {
        let word = |word| occlusion::word::<f32, 1>(frame, views, lists, geometry, word, &[found])[0].0;
        return ((0..frame.mask_words).map(word).collect(), vec![]);
    }
    let tint = |light| {
        let asked = [occlusion::ask(frame, views, light, &found)];
        occlusion::tint::<f32, 1>(frame, views, lists, geometry, light, &[found.origin], &asked)[0].0
    };
    let tints: Vec<u32> = (0..frame.lights).map(tint).collect();
    let mask = |word| occlusion::mask(frame, word, Word(0), |light| Word(tints[light as usize])).0;
    ((0..frame.mask_words).map(mask).collect(), tints)
}

#[test]
fn runs() {
    main().expect("no error");
}
