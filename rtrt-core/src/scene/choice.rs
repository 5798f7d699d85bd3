//! Settings of a scene that change no picture, or little of it.

/// How mip levels are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mip {
    /// By the distance of a surface, as in the paper.
    #[default]
    Distance,
    /// By the distance and the angle of the surface: the footprint is divided by the cosine between ray and
    /// normal, so grazing surfaces are blurred rather than noisy.
    Angle,
}

/// The structure that limits the instances a ray is tested against. No picture depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Structure {
    /// Each block of each view has a list of instances that its rays may hit. The camera's lists hold parts
    /// of instances if the scene has few instances with many triangles.
    #[default]
    Blocks,
    /// Each block of each view has a list of the instances that its rays may hit.
    Objects,
    /// The camera's lists hold parts of instances: the largest nodes of their BVHs with at most this many
    /// triangles; with 1 (or 0) the leaves. Lights have lists of instances.
    Parts(u32),
    /// All blocks of a view share one list of all instances, in their order. It shows the gain of blocks.
    None,
}

/// Which instances cast shadows of suns.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Occluders {
    /// All.
    #[default]
    All,
    /// Those within this distance of the camera, world units: the paper's one list for all lights
    /// of infinite range. Shadows of what is farther away are missing.
    Near(f32),
}
