//! The reference against the oracles.

use conformance::oracle::{brute, wide};
use conformance::{Suite, cases};

#[test]
fn no_hit_and_no_shadow_is_lost_to_culling() {
    for (case, scene, picture) in Suite::new(cases::all()).pictures() {
        if let Err(difference) = brute::check(scene, &case.request(), picture, 1) {
            panic!("{}: {difference}", case.name);
        }
    }
}

#[test]
fn hits_and_shadows_are_where_they_must_be() {
    let mut all = wide::Judged::default();
    for (case, scene, picture) in Suite::new(cases::all()).pictures() {
        let judged = wide::check(scene, &case.request(), picture, 1);
        let judged = judged.unwrap_or_else(|why| panic!("{}: {why}", case.name));
        println!("{}: {judged:?}", case.name);
        all.rays += judged.rays;
        all.judged += judged.judged;
        all.edges += judged.edges;
        all.shadow_rays += judged.shadow_rays;
        all.judged_shadow_rays += judged.judged_shadow_rays;
    }
    // An oracle that judges nothing would be no oracle.
    assert!(all.judged * 10 > all.rays * 8, "{all:?}");
    assert!(all.edges > 1000, "{all:?}");
    assert!(all.judged_shadow_rays * 10 > all.shadow_rays * 5, "{all:?}");
}
