//! The cases, in files named for the kernels and stages that they are about.

mod ambient;
mod area;
mod bin;
mod camera;
mod environment;
mod extension;
mod light;
mod material;
mod motion;
mod shadow;
mod share;
mod soft;
mod sphere;
mod surface;
mod texture;
mod tone;
mod transparency;
mod visibility;

use crate::case::Case;

/// All cases, in the order of the stages.
pub fn all() -> impl Iterator<Item = &'static Case> {
    let files = [
        camera::CASES,
        bin::CASES,
        visibility::CASES,
        surface::CASES,
        share::CASES,
        sphere::CASES,
        texture::CASES,
        material::CASES,
        extension::CASES,
        shadow::CASES,
        area::CASES,
        soft::CASES,
        light::CASES,
        environment::CASES,
        ambient::CASES,
        transparency::CASES,
        motion::CASES,
        tone::CASES,
    ];
    files.into_iter().flatten()
}

/// The case of this name, if there is one.
pub fn named(name: &str) -> Option<&'static Case> {
    all().find(|case| case.name == name)
}
