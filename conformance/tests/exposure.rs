//! The meter: the same stops on every backend.

use conformance::variants::{all, present, requires_gpu};
use conformance::{cases, reference};
use rtrt_core::backend::Backend;

#[test]
fn every_backend_meters_the_same_stops() {
    let mut reference = reference();
    let mut present = present(all(), requires_gpu());
    assert_eq!(present.failed, 0);
    let mut metered = 0;
    for name in
        ["tone/neutral", "tone/behind_nothing", "environment/turned", "light/spot", "soft/four_samples"]
    {
        let case = cases::named(name).expect("a case");
        let scene = (case.scene)();
        let request = case.request().size([300, 170]);
        let expected = reference.meter(&scene, &request).expect("stops");
        assert!(expected != 0.0 && expected.abs() < 12.0, "{name}: {expected}");
        // What the request says of exposure changes nothing.
        assert_eq!(reference.meter(&scene, &request.exposure(3.0)).expect("stops"), expected);
        for (variant, backend) in &mut present.backends {
            assert_eq!(backend.meter(&scene, &request).expect("stops"), expected, "{name}, {variant}");
            metered += 1;
        }
    }
    assert!(metered > 0);
}
