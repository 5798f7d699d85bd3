//! A backend of somebody else's: one thread, one ray after another, through the steps of `rtrt-core`. It passes
//! the conformance suite.
//!
//! ```text
//! $ cargo run --release -p conformance --example custom_backend
//! 194 cases on one ray after another: 0 differ
//! ```
//!
//! A backend decides where and when the steps of a frame run; what they compute is theirs. This one keeps nothing
//! between frames, and is as slow as it is short.

use bytemuck::Zeroable;
use conformance::{Suite, cases};
use rtrt_core::backend::{Backend, Deferred, Description, Picture, RenderError, Request};
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::lists::{BlockLists, ListEntry};
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::lane::Word;
use rtrt_core::layout::{Frame, Hit, Instance, ShadowBuffer, View};
use rtrt_core::scene::{Scene, Setup};
use rtrt_core::schedule::{Pass, steps};
use rtrt_core::stage::context::Context;
use rtrt_core::stage::light::{IncomingLight, ShadowTerms};
use rtrt_core::stage::peel::LayerSum;
use rtrt_core::stage::surface::Surfaces;
use rtrt_core::stage::visibility::{directions, hit};
use rtrt_core::stage::{
    ambient, bin, detail, light, occlusion, peel, penumbra_filter, prepare, resolve, shade, share, surface,
    visibility,
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
        let Setup { frame, views, .. } = &self.setup;
        let geometry = self.setup.geometry(scene);
        let (mut bounds, mut lists) = (vec![], vec![]);
        let (mut now, mut first_layer) = (Deferred::default(), Deferred::default());
        now.resize(frame);
        // A hit at 0 says that nothing has been looked for yet.
        now.hits.fill(Hit::zeroed());
        // The first records of all rays, then the second ones, and so on.
        now.colors.resize((frame.records().max(2) * frame.rays) as usize, [1.0; 4]);
        let mut shadows = vec![0; (ShadowBuffer::new(frame).words_per_ray() * frame.rays) as usize];
        let mut around = vec![[0.0; 2]; frame.rays as usize];
        [picture.width, picture.height] = request.size;
        picture.pixels.resize((frame.width * frame.height) as usize, 0);
        for step in steps(frame) {
            let frame = &frame.of_layer(step.layer);
            let [units, lights] = step.unit().count(frame);
            match step.pass {
                Pass::Prepare => {
                    let of = |unit| prepare::prepare(frame, views, geometry.instances, unit);
                    bounds = (0..units).map(of).collect();
                }
                Pass::Bin => lists = sorted_lists(frame, views, geometry.instances, &bounds),
                pass => {
                    let lists = BlockLists { data: &lists, blocks: frame.blocks };
                    let context = Context { frame, views, lists, geometry };
                    for at in (0..units).flat_map(|unit| (0..lights).map(move |light| [unit, light])) {
                        let scratch = (&mut shadows[..], &mut around[..]);
                        run(pass, at, scene, &context, &mut now, scratch, &mut picture.pixels);
                    }
                }
            }
            if step.pass == Pass::Shade {
                first_layer = now.clone();
            }
        }
        let Deferred { mut colors, layers, .. } = now;
        colors.truncate(frame.rays as usize);
        picture.deferred = request.deferred.then_some(Deferred { lists, colors, layers, ..first_layer });
        Ok(())
    }
}

/// The lists of all blocks, each in the order of `(key, instance)`.
fn sorted_lists(frame: &Frame, views: &[View], instances: &[Instance], bounds: &[ScreenBounds]) -> Vec<u32> {
    let mut blocks: Vec<Vec<ListEntry>> = vec![vec![]; frame.blocks as usize];
    for index in 0..bounds.len() as u32 {
        let add = |block: u32, entry| blocks[block as usize].push(entry);
        bin::each_block(frame, views, instances, bounds, index, add);
    }
    let mut words = vec![0];
    for block in &mut blocks {
        block.sort_by_key(|entry| (entry.key, entry.instance));
        words.push(words[words.len() - 1] + block.len() as u32);
    }
    words.extend(blocks.iter().flatten().flat_map(|entry| [entry.key, entry.instance]));
    words
}

/// Runs a pass on one ray or pixel, and one light. `now` are the records of the layer that rays look at, `shadows`
/// its shadows before they are filtered, `around` what they find of the light from all around.
fn run(
    pass: Pass,
    [unit, light]: [u32; 2],
    scene: &Scene,
    context: &Context<'_>,
    now: &mut Deferred,
    (shadows, around): (&mut [u32], &mut [[f32; 2]]),
    pixels: &mut [u32],
) {
    let Deferred { hits, surfaces, masks, transmittance, lit, colors, layers, layer_count, .. } = now;
    let Context { frame, views, geometry, .. } = context;
    let (at, ray, camera, maps) = (unit as usize, RayIndex(unit), context.camera(), &scene.maps());
    let [direction] = directions::<f32, 1>((), frame, camera, ray);
    let (closest, found) = (ClosestHit::<f32>::new(&hits[at]), Surfaces::<f32>::new(&surfaces[at]));
    let buffer = ShadowBuffer::new(frame);
    let word_at = |light| buffer.transmittance(unit, light);
    match pass {
        Pass::Visibility => hits[at] = hit(&visibility::visibility::<f32, 1>((), context, ray)[0], 0),
        Pass::EndCovered if peel::is_covered(colors[at][3]) => hits[at] = Hit::MISS,
        Pass::Peel => hits[at] = hit(&peel::peel::<f32, 1>((), context, ray, &[closest])[0], 0),
        Pass::Share => share::share(frame, hits, frame.grid().first_ray(unit).0),
        Pass::Surface => {
            let found = surface::surface(camera, geometry, scene.attributes(), direction, &closest);
            surfaces[at] = found.lane(0);
        }
        Pass::Detail => {
            let vertices = context.vertices(scene.attributes());
            surfaces[at] = detail::detail(frame, maps, &vertices, &closest, &found).lane(0);
        }
        Pass::Occlusion => {
            let (word, bit) = occlusion::place(frame, unit, light);
            masks[word as usize] |= occlusion::occlusion::<f32, 1>(context, light, ray, &[found])[0].0 << bit;
        }
        Pass::Transmittance | Pass::BlockerSearch => {
            let active = [occlusion::potentially_lit(frame, views, light, ray, &found)];
            let (origin, at) = ([found.origin], word_at(light));
            if pass == Pass::Transmittance {
                let [arrival] =
                    occlusion::transmittance::<f32, false, 1>(context, light, ray, &origin, &active);
                transmittance[at] = arrival.transmittance.0;
            } else {
                let [arrival] =
                    occlusion::transmittance::<f32, true, 1>(context, light, ray, &origin, &active);
                shadows[at] = arrival.transmittance.0;
                shadows[buffer.penumbra_radius(unit, light)] = arrival.penumbra_radius.to_bits();
                now.raw_transmittance[at] = arrival.transmittance.0;
                now.penumbra_radii[at] = arrival.penumbra_radius;
            }
        }
        Pass::FilterPenumbra => {
            let at = frame.grid().ray(ray);
            let band = penumbra_filter::Band { frame, surfaces, shadows, light, at };
            let word = penumbra_filter::filter_penumbra::<f32, _>(frame, views, &band, light);
            transmittance[word_at(light)] = word.0;
        }
        Pass::Mask => {
            let tint = |light| Word(transmittance[word_at(light)]);
            for word in 0..frame.mask_words {
                masks[(unit * frame.mask_words + word) as usize] =
                    occlusion::mask(frame, word, Word(0), tint).0;
            }
        }
        Pass::Ambient => around[at] = ambient::ambient::<f32, 1>(context, ray, &[found])[0],
        Pass::Light => {
            let mask = |word: u32| Word(masks[(unit * frame.mask_words + word) as usize]);
            let terms = ShadowTerms::new(mask, |light| Word(transmittance[word_at(light)]));
            lit[at] = light::light::<f32>(frame, views, maps, &terms, ray, direction, &found).lane(0);
        }
        Pass::Shade | Pass::Blend => {
            let record = |ray: u32| ambient::record(around[ray as usize], &surfaces[ray as usize]);
            let share = ambient::share::<f32>((), frame, unit, record);
            let rays = frame.rays as usize;
            let mut before = LayerSum::new(direction);
            if pass == Pass::Blend {
                // Records beyond those that the frame keeps do not count.
                let kept = |number: usize| number.min(frame.records() as usize - 1);
                let record = |number| colors[kept(number) * rays + at];
                before = LayerSum::load(frame, direction, std::array::from_fn(record));
            }
            let incoming = IncomingLight::new(&lit[at]);
            let shaded = shade::shade(frame, maps, direction, &before.beyond, &found, &incoming, share);
            if pass == Pass::Blend {
                layers[(unit * *layer_count + *layer_count - frame.layers) as usize] = hits[at];
            }
            if frame.has_layers() {
                let sum = before.blend(frame, &shaded);
                for number in 0..frame.records() {
                    colors[number as usize * rays + at] = sum.record(number);
                }
            } else {
                colors[at] = shaded.record();
            }
        }
        Pass::Resolve => {
            let grid = frame.grid();
            let shaded = |ray| share::shaded(ray, &hits[ray as usize]);
            let color = |RayIndex(ray)| colors[if frame.is_shared == 1 { shaded(ray) } else { ray } as usize];
            let through = |ray: RayIndex| colors[(ray.0 + frame.rays) as usize];
            let first = grid.first_ray(unit);
            let color = |_| resolve::average(frame.side, first, color);
            let through = |_| resolve::average(frame.side, first, through);
            pixels[at] = resolve::resolve::<f32>((), frame, color, through).0;
        }
        Pass::EndCovered => {}
        // It filters every block, draws nothing, and prepares and bins before all passes.
        Pass::Prepare | Pass::Bin | Pass::Pick | Pass::SummarizePenumbras | Pass::SelectFilterBlocks => {}
    }
}

#[test]
fn runs() {
    main().expect("no error");
}
