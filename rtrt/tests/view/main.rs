//! `rtrt view` in a real window: under Xvfb, a display without a screen. Input comes from recordings.

mod display;
mod entries;
mod hands;
mod keys;
mod pace;
mod panel;
mod pictures;
mod recordings;
mod refusals;
