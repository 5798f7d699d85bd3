//! Choices that a scene offers, and that change no picture, or little of it.

/// How the levels of textures are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mip {
    /// By the distance of a surface, as in the paper.
    #[default]
    Distance,
    /// By its distance and the angle at which it is seen: its footprint is divided by the cosine
    /// between ray and normal, so that what is seen at a grazing angle is blurred rather than
    /// noisy.
    Angle,
}

/// What keeps rays from being asked for every instance. No picture depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Structure {
    /// Each block of each view has a list of what its rays may meet: of the camera's views, parts
    /// of instances while there are few instances with many triangles, or else instances.
    #[default]
    Blocks,
    /// Each block of each view has a list of the instances that its rays may meet.
    Objects,
    /// The lists of the camera's blocks hold parts of instances: of their meshes' trees the largest
    /// nodes that have at most so many triangles; with 1 (or 0), all leaves. Lights have lists of
    /// instances.
    Parts(u32),
    /// Nothing: all blocks of a view share one list of all instances, in their order. To show what
    /// blocks are worth.
    None,
}

/// Which instances cast shadows of suns.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Occluders {
    /// All.
    #[default]
    All,
    /// Those whose shadows may fall on what the camera sees, by the planes around the picture. No
    /// picture depends on it.
    Seen,
    /// Those within this distance of the camera, world units: the paper's one list for all lights
    /// of infinite range. Shadows of what is farther away are missing.
    Near(f32),
}
