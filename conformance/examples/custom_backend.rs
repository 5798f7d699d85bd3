//! A backend of somebody else's: one thread, one ray after another, through the stages of `rtrt-core`. It passes
//! the conformance suite.
//!
//! ```text
//! $ cargo run --release -p conformance --example custom_backend
//! 191 cases on one ray after another: 0 differ
//! ```
//!
//! A backend decides where and when the stages run; what they compute is theirs. This one keeps nothing between
//! frames, and is as slow as it is short.

use bytemuck::Zeroable;
use conformance::{Suite, cases};
use rtrt_core::backend::{Backend, Deferred, Description, Picture, RenderError, Request};
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::lists::{BlockLists, ListEntry};
use rtrt_core::kernel::texture::Maps;
use rtrt_core::lane::Word;
use rtrt_core::layout::{Frame, Hit, ShadowBuffer, Surface};
use rtrt_core::scene::{Scene, Setup};
use rtrt_core::stage::context::Context;
use rtrt_core::stage::surface::{Surfaces, Vertices};
use rtrt_core::stage::visibility::{directions, hit, visibility};
use rtrt_core::stage::{
    bin, detail, light, occlusion, peel, penumbra_filter, prepare, resolve, shade, surface,
};

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
        self.setup.prepare(scene, request)?;
        let frame = self.setup.frame;
        let grid = frame.grid();
        let words = lists(&self.setup, scene);
        let job = Job::new(&self.setup, scene, &words);
        let mut kept = room(&frame);
        let mut layer = Layer::new(&frame);
        for number in 0..frame.layers.max(1) {
            let frame = Frame { layers: frame.layers.saturating_sub(number), ..frame };
            job.find(&frame, &mut layer);
            job.shadows(&frame, &mut layer);
            if number == 0 && frame.penumbra_window > 0 {
                let (left, sizes) = layer.shadows.split_at(ShadowBuffer::new(&frame).penumbra_radius(0, 0));
                kept.raw_transmittance = left.to_vec();
                kept.penumbra_radii = sizes.iter().map(|&bits| f32::from_bits(bits)).collect();
            }
            job.shade(&frame, number, &mut layer, &mut kept);
        }
        let pixel = |number: u32| {
            let color = |ray: RayIndex| kept.colors[ray.0 as usize];
            resolve::resolve::<f32>((), grid, |_| grid.pixel(number), color).0
        };
        picture.pixels = (0..frame.width * frame.height).map(pixel).collect();
        [picture.width, picture.height] = request.size;
        kept.lists = words;
        picture.deferred = request.deferred.then_some(kept);
        Ok(())
    }
}

/// Buffers for a frame in which nothing has been hit.
fn room(frame: &Frame) -> Deferred {
    let rays = frame.rays as usize;
    let transmittance_words = if frame.has_transmittance() { frame.lights } else { 0 };
    let layer_count = frame.layers.max(1) - 1;
    Deferred {
        hits: vec![Hit::MISS; rays],
        surfaces: vec![Zeroable::zeroed(); rays],
        masks: vec![0; rays * frame.mask_words as usize],
        transmittance: vec![0; rays * transmittance_words as usize],
        lit: vec![Zeroable::zeroed(); rays],
        colors: vec![[0.0; 4]; rays],
        layers: vec![Hit::MISS; rays * layer_count as usize],
        mask_words: frame.mask_words,
        layer_count,
        transmittance_words,
        ..Deferred::default()
    }
}

/// The stages `prepare` and `bin`: the lists of all blocks, each in the order of `(key, instance)`.
fn lists(setup: &Setup, scene: &Scene) -> Vec<u32> {
    let (frame, views, instances) = (&setup.frame, &setup.views[..], setup.instances(scene));
    let count = prepare::count(frame);
    let screen_bounds: Vec<_> = (0..count).map(|i| prepare::prepare(frame, views, instances, i)).collect();
    let mut blocks: Vec<Vec<ListEntry>> = vec![vec![]; frame.blocks as usize];
    for index in 0..count {
        bin::each_block(frame, views, instances, &screen_bounds, index, |block, entry| {
            blocks[block as usize].push(entry);
        });
    }
    let mut words = vec![0];
    for block in &mut blocks {
        block.sort_by_key(|entry| (entry.key, entry.instance));
        words.push(words[words.len() - 1] + block.len() as u32);
    }
    words.extend(blocks.iter().flatten().flat_map(|entry| [entry.key, entry.instance]));
    words
}

/// What is known of the layer of surfaces that rays look at, a record a ray.
struct Layer {
    hits: Vec<Hit>,
    surfaces: Vec<Surface>,
    /// Where shadows are soft, what they are before they are blurred.
    shadows: Vec<u32>,
    /// Whether nothing more is looked for.
    is_done: Vec<bool>,
}

impl Layer {
    fn new(frame: &Frame) -> Self {
        let (rays, lights) = (frame.rays as usize, frame.lights as usize);
        Self {
            // A hit at 0 says that nothing has been looked for yet.
            hits: vec![Hit::zeroed(); rays],
            surfaces: vec![Surface::zeroed(); rays],
            shadows: vec![0; if frame.penumbra_window > 0 { 2 * rays * lights } else { 0 }],
            is_done: vec![false; rays],
        }
    }
}

/// What the stages read.
struct Job<'a> {
    setup: &'a Setup,
    trace: Context<'a>,
    maps: Maps<'a>,
    vertices: Vertices<'a>,
}

impl<'a> Job<'a> {
    fn new(setup: &'a Setup, scene: &'a Scene, words: &'a [u32]) -> Self {
        let instances = setup.instances(scene);
        Self {
            setup,
            trace: Context {
                frame: &setup.frame,
                views: &setup.views,
                lists: BlockLists { data: words, blocks: setup.frame.blocks },
                geometry: Geometry {
                    instances,
                    nodes: scene.nodes(),
                    mesh_data: scene.mesh_data(),
                    positions: scene.positions(),
                    texels: scene.texels(),
                    magnitude: setup.frame.magnitude,
                },
            },
            maps: Maps { materials: scene.materials(), texels: scene.texels() },
            vertices: Vertices { instances, mesh_data: scene.mesh_data(), attributes: scene.attributes() },
        }
    }

    /// The stages `visibility` and `surface`.
    fn find(&self, frame: &Frame, layer: &mut Layer) {
        let Self { trace, maps, vertices, .. } = self;
        let (trace, camera) = (Context { frame, ..*trace }, trace.camera());
        for ray in 0..frame.rays {
            let (at, number) = (ray as usize, RayIndex(ray));
            let [direction] = directions::<f32, 1>((), frame, camera, number);
            let best = if frame.layers == 0 {
                visibility::<f32, 1>((), &trace, number)
            } else {
                let last = [ClosestHit::new(&layer.hits[at])];
                peel::peel::<f32, 1>((), &trace, number, &last)
            };
            let mut found =
                surface::surface(camera, &trace.geometry, vertices.attributes, direction, &best[0]);
            if frame.details == 1 {
                found = detail::detail(maps, vertices, &best[0], &found);
            }
            layer.hits[at] = hit(&best[0], 0);
            layer.surfaces[at] = found.lane(0);
        }
    }

    /// Of the stage `occlusion`, what all rays must have done before the first of them is lit: what is left of
    /// each light, and the penumbras, where shadows are soft.
    fn shadows(&self, frame: &Frame, layer: &mut Layer) {
        let trace = Context { frame, ..self.trace };
        for ray in (0..frame.rays).filter(|_| frame.penumbra_window > 0) {
            let found = Surfaces::<f32>::new(&layer.surfaces[ray as usize]);
            let (number, origin) = (RayIndex(ray), [found.origin]);
            let buffer = ShadowBuffer::new(frame);
            for light in 0..frame.lights {
                let asked = [occlusion::potentially_lit(frame, trace.views, light, number, &found)];
                let [arrival] =
                    occlusion::transmittance::<f32, true, 1>(&trace, light, number, &origin, &asked);
                layer.shadows[buffer.transmittance(ray, light)] = arrival.transmittance.0;
                layer.shadows[buffer.penumbra_radius(ray, light)] = arrival.penumbra_radius.to_bits();
            }
        }
    }

    /// The stages from `occlusion` to `layers`.
    fn shade(&self, frame: &Frame, number: u32, layer: &mut Layer, kept: &mut Deferred) {
        let views = &self.setup.views[..];
        let camera = &views[Frame::CAMERA as usize];
        for ray in 0..frame.rays {
            let (at, index) = (ray as usize, RayIndex(ray));
            if layer.is_done[at] {
                continue;
            }
            let found = Surfaces::<f32>::new(&layer.surfaces[at]);
            let [direction] = directions::<f32, 1>((), frame, camera, index);
            let (masks, transmittance) = self.reaching(frame, layer, ray, &found);
            let mask = |word: u32| Word(masks[word as usize]);
            let tint = |light: u32| Word(transmittance[light as usize]);
            let shadows = light::ShadowTerms::new(mask, tint);
            let arriving = light::light(frame, views, &self.maps, &shadows, index, direction, &found);
            let shaded = shade::shade(frame, &self.maps, direction, &found, &arriving);
            let sum = if frame.layers == 0 { shaded } else { peel::blend(frame, kept.colors[at], shaded) };
            kept.colors[at] = sum;
            if number == 0 {
                kept.hits[at] = layer.hits[at];
                kept.surfaces[at] = layer.surfaces[at];
                kept.masks[at * masks.len()..][..masks.len()].copy_from_slice(&masks);
                kept.transmittance[at * transmittance.len()..][..transmittance.len()]
                    .copy_from_slice(&transmittance);
                kept.lit[at] = arriving.lane(0);
            } else {
                kept.layers[at * kept.layer_count as usize + number as usize - 1] = layer.hits[at];
            }
            // What nothing shines through hides the others.
            if peel::is_covered(sum[3]) || layer.hits[at] == Hit::MISS {
                layer.is_done[at] = true;
                layer.hits[at] = Hit::MISS;
            }
        }
    }

    /// The words of a ray's shadow mask, and what is left of each light if not everything is opaque or shadows are
    /// soft.
    fn reaching(
        &self,
        frame: &Frame,
        layer: &Layer,
        ray: u32,
        found: &Surfaces<f32>,
    ) -> (Vec<u32>, Vec<u32>) {
        let trace = Context { frame, ..self.trace };
        let (views, index) = (trace.views, RayIndex(ray));
        if !frame.has_transmittance() {
            let word = |word| occlusion::word::<f32, 1>(&trace, word, index, &[*found])[0].0;
            return ((0..frame.mask_words).map(word).collect(), vec![]);
        }
        let tint = |light| {
            if frame.penumbra_window > 0 {
                let (surfaces, shadows, at) =
                    (&layer.surfaces[..], &layer.shadows[..], frame.grid().ray(index));
                let band = penumbra_filter::Band { frame, surfaces, shadows, light, at };
                return penumbra_filter::filter_penumbra::<f32, _>(frame, views, &band, light).0;
            }
            let asked = [occlusion::potentially_lit(frame, views, light, index, found)];
            let origin = [found.origin];
            occlusion::transmittance::<f32, false, 1>(&trace, light, index, &origin, &asked)[0]
                .transmittance
                .0
        };
        let transmittance: Vec<u32> = (0..frame.lights).map(tint).collect();
        let mask =
            |word| occlusion::mask(frame, word, Word(0), |light| Word(transmittance[light as usize])).0;
        ((0..frame.mask_words).map(mask).collect(), transmittance)
    }
}

#[test]
fn runs() {
    main().expect("no error");
}
