//! The `rtrt` command as a shell sees it: exit codes, output, files.

mod animation;
mod background;
mod cache;
mod cameras;
mod compare;
mod cube;
mod defaults;
mod ending;
mod environment;
mod exposure;
mod failures;
mod folder;
mod help;
mod hybrid;
mod input;
mod instructions;
mod layers;
mod names;
mod pictures;
mod reports;
mod shading;
mod shorthand;
mod streams;
mod surroundings;
mod talk;
mod verify;
