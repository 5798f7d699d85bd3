//! The radius of the penumbra that an occluder casts.

use crate::lane::{Lane, Select};
use crate::layout::{View, ViewKind};
use crate::num::{clamp, flush, recip};

/// The least share of a shadow ray between blocker and light: a blocker that touches the light would cast a
/// penumbra without end.
const LEAST: f32 = 1.0 / 1024.0;
/// The largest radius of a penumbra: its square is a number, too.
const MOST: f32 = f32::from_bits((127 + 40) << 23);

/// Radius of the penumbra that the nearest blocker casts on a surface, across the light's way; −1 without
/// a blocker.
///
/// ```text
/// point light: light radius · blocker / (1 − blocker)
/// sun:         light radius · blocker
/// ```
///
/// The paper's formula (Analytical soft shadows), light radius · occluder distance / light distance. The
/// occluder's distance is that from the surface, the light's that from the occluder: then it is the
/// intercept theorem, and exact for an edge across the light's way. Both are shares of the shadow ray,
/// whose length cancels. For a sun, radius over distance is the tangent of its radius.
///
/// | value     | unit                                | range                                      |
/// |-----------|-------------------------------------|--------------------------------------------|
/// | `blocker` | shadow rays; of a sun, world units  | ≥ 0; `f32::MAX` for none                   |
/// | result    | world units                         | 0 ..= 2⁴⁰, or −1                           |
#[inline(always)]
pub fn penumbra_radius<L: Lane>(light: &View, blocker: L) -> L {
    let size = if light.kind == ViewKind::Sun as u32 {
        blocker * light.radius
    } else {
        let beyond = blocker.broadcast(1.0) - blocker;
        blocker * light.radius * recip(beyond.max(beyond.broadcast(LEAST)))
    };
    let is_unblocked = blocker.ge(blocker.broadcast(f32::MAX));
    is_unblocked.select(blocker.broadcast(-1.0), flush(clamp(size, 0.0, MOST)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn is_the_theorem_of_intersecting_lines() {
        let at = |kind: ViewKind, t: f32| {
            let light = View { kind: kind as u32, radius: 0.5, ..View::zeroed() };
            penumbra_radius(&light, t)
        };
        // A quarter of the way: three times as far from the light as from the surface.
        assert!((at(ViewKind::Point, 0.25) - 0.5 / 3.0).abs() < 1e-7);
        assert!((at(ViewKind::Point, 0.5) - 0.5).abs() < 1e-7);
        assert_eq!((at(ViewKind::Point, 0.0), at(ViewKind::Point, 1.0).round()), (0.0, 512.0));
        assert_eq!((at(ViewKind::Sun, 3.0), at(ViewKind::Sun, f32::MAX)), (1.5, -1.0));
    }
}
