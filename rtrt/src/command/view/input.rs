//! Input events as text, one a line, for recordings and replays.
//!
//! ```text
//! rtrt input 1
//! size 640 360 1
//! press W
//! frames 30 0.016666668
//! release W
//! press F12
//! frame 0.016666668
//! ```
//!
//! `point TEXT` moves the pointer to a text that the frame before showed, `beside TEXT` to what is on its right, and
//! `before TEXT` to what is on its left.
//!
//! Events stand before the frame that handles them. A frame has the seconds since the frame before it, so a
//! file always gives the same frames. Lines that begin with # are comments.

use egui::Key;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The first line of a recording.
const HEADER: &str = "rtrt input 1";

/// An event of a window. Positions are in pixels from the upper left corner.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A new size of the window, and the pixels per unit of the user interface.
    Size([u32; 2], f32),
    Press(Key),
    Release(Key),
    Modifiers(Modifiers),
    /// Text from the keyboard.
    Text(String),
    /// Text from the clipboard.
    Paste(String),
    /// A new position of the pointer.
    Move(f32, f32),
    /// The pointer left the window.
    Leave,
    Button(Button, bool),
    /// Notches of the wheel; up is positive.
    Wheel(f32),
    /// Two fingers apart by this factor.
    Pinch(f32),
    /// Two fingers along by so many pixels.
    Pan(f32, f32),
    /// The window got or lost the keyboard.
    Focus(bool),
    /// A file was dropped on the window.
    Drop(PathBuf),
    /// The pointer moved to a text. Only who writes a recording by hand has it; it is recorded as a move.
    Point(Point),
}

/// A place in the window, named by the text that is there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Point {
    pub text: String,
    pub side: Side,
}

/// Where something is, seen from a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    On,
    Right,
    Left,
}

impl Side {
    const NAMES: [(&'static str, Self); 3] =
        [("point", Self::On), ("beside", Self::Right), ("before", Self::Left)];
}

impl Event {
    /// Whether a person waits for an effect, so that a picture that is only refined can wait. A pointer that moves without
    /// a button may change nothing.
    pub fn is_urgent(&self, is_held: bool) -> bool {
        match self {
            Self::Move(..) => is_held,
            Self::Leave | Self::Focus(_) | Self::Modifiers(_) => false,
            _ => true,
        }
    }
}

/// The modifier keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Modifiers {
    pub ctrl: bool,
    pub shift: bool,
    pub alt: bool,
}

/// A button of the mouse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Button {
    Left,
    Middle,
    Right,
}

impl Button {
    const NAMES: [(&'static str, Self); 3] =
        [("left", Self::Left), ("middle", Self::Middle), ("right", Self::Right)];
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size([width, height], scale) => write!(f, "size {width} {height} {scale}"),
            Self::Press(key) => write!(f, "press {}", key.name()),
            Self::Release(key) => write!(f, "release {}", key.name()),
            Self::Modifiers(Modifiers { ctrl, shift, alt }) => {
                f.write_str("modifiers")?;
                let names = [(ctrl, " ctrl"), (shift, " shift"), (alt, " alt")];
                names.iter().filter(|(held, _)| **held).try_for_each(|(_, name)| f.write_str(name))
            }
            Self::Text(text) => write!(f, "text {}", text.escape_default()),
            Self::Paste(text) => write!(f, "paste {}", text.escape_default()),
            Self::Move(x, y) => write!(f, "move {x} {y}"),
            Self::Leave => f.write_str("leave"),
            Self::Button(button, pressed) => {
                let name = Button::NAMES.iter().find(|(_, known)| known == button);
                let down = if *pressed { "down" } else { "up" };
                write!(f, "button {} {down}", name.map_or("left", |(name, _)| name))
            }
            Self::Wheel(notches) => write!(f, "wheel {notches}"),
            Self::Pinch(factor) => write!(f, "pinch {factor}"),
            Self::Pan(x, y) => write!(f, "pan {x} {y}"),
            Self::Focus(has) => write!(f, "focus {}", if *has { "gained" } else { "lost" }),
            Self::Drop(path) => write!(f, "drop {}", path.to_string_lossy().escape_default()),
            Self::Point(Point { text, side }) => {
                let name = Side::NAMES.iter().find(|(_, known)| known == side);
                write!(f, "{} {}", name.map_or("point", |(name, _)| name), text.escape_default())
            }
        }
    }
}

impl FromStr for Event {
    type Err = &'static str;

    fn from_str(line: &str) -> Result<Self, Self::Err> {
        let (what, rest) = line.split_once(' ').unwrap_or((line, ""));
        let words: Vec<&str> = rest.split_whitespace().collect();
        let key = |name: &str| Key::from_name(name).ok_or("no such key");
        Ok(match (what, words.as_slice()) {
            ("size", [width, height, scale]) => {
                let side = |text: &str| text.parse().ok().filter(|side| (1..=16_384).contains(side));
                let size = side(width).zip(side(height)).ok_or("a side is not within 1 and 16384")?;
                let scale = number(scale).filter(|scale| (0.1..=20.0).contains(scale));
                Self::Size(size.into(), scale.ok_or("the scale is not within 0.1 and 20")?)
            }
            ("press", [name]) => Self::Press(key(name)?),
            ("release", [name]) => Self::Release(key(name)?),
            ("modifiers", names) => {
                if let Some(_unknown) = names.iter().find(|name| !["ctrl", "shift", "alt"].contains(name)) {
                    return Err("modifiers are ctrl, shift and alt");
                }
                let held = |name| names.contains(&name);
                Self::Modifiers(Modifiers { ctrl: held("ctrl"), shift: held("shift"), alt: held("alt") })
            }
            ("text", _) => Self::Text(unescaped(rest).ok_or("an escape is not complete")?),
            ("paste", _) => Self::Paste(unescaped(rest).ok_or("an escape is not complete")?),
            (what @ ("move" | "pan"), [x, y]) => {
                let (x, y) = number(x).zip(number(y)).ok_or("not two finite numbers")?;
                if what == "move" { Self::Move(x, y) } else { Self::Pan(x, y) }
            }
            ("pinch", [factor]) => {
                let factor = number(factor).filter(|factor| (1e-3..=1e3).contains(factor));
                Self::Pinch(factor.ok_or("the factor is not within 0.001 and 1000")?)
            }
            ("leave", []) => Self::Leave,
            ("button", [name, state]) => {
                let button = Button::NAMES.iter().find(|(known, _)| known == name);
                let (_, button) = button.ok_or("buttons are left, middle and right")?;
                Self::Button(*button, one_of(state, ["up", "down"]).ok_or("a button goes up or down")?)
            }
            ("wheel", [notches]) => Self::Wheel(number(notches).ok_or("not a finite number")?),
            ("focus", [state]) => {
                Self::Focus(one_of(state, ["lost", "gained"]).ok_or("focus is gained or lost")?)
            }
            (what, [_, ..]) if let Some((_, side)) = Side::NAMES.iter().find(|(name, _)| *name == what) => {
                Self::Point(Point { text: unescaped(rest).ok_or("an escape is not complete")?, side: *side })
            }
            ("drop", [_, ..]) => Self::Drop(unescaped(rest).ok_or("an escape is not complete")?.into()),
            _ => return Err("no such event"),
        })
    }
}

/// A finite number within the range of positions.
fn number(text: &str) -> Option<f32> {
    text.parse().ok().filter(|number: &f32| number.abs() <= 1e6)
}

/// Whether a word is the second of two; none if it is neither.
fn one_of(word: &str, words: [&str; 2]) -> Option<bool> {
    words.iter().position(|known| *known == word).map(|place| place == 1)
}

/// The text that [`char::escape_default`] escaped.
fn unescaped(text: &str) -> Option<String> {
    let mut chars = text.chars();
    let mut plain = String::new();
    while let Some(c) = chars.next() {
        plain.push(match c {
            '\\' => match chars.next()? {
                'n' => '\n',
                'r' => '\r',
                't' => '\t',
                'u' => {
                    let digits: String =
                        chars.by_ref().skip_while(|c| *c == '{').take_while(|c| *c != '}').collect();
                    char::from_u32(u32::from_str_radix(&digits, 16).ok()?)?
                }
                other => other,
            },
            other => other,
        });
    }
    Some(plain)
}

/// The events before a frame, and the seconds since the frame before it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Step {
    pub events: Vec<Event>,
    pub seconds: f32,
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.events.iter().try_for_each(|event| writeln!(f, "{event}"))?;
        writeln!(f, "frame {}", self.seconds)
    }
}

/// The first line of a recording.
pub fn header() -> String {
    format!("{HEADER}\n")
}

/// An error in a recording, with its line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Malformed {
    line: usize,
    why: &'static str,
}

impl fmt::Display for Malformed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.why)
    }
}

/// A recording, read frame by frame.
#[derive(Debug, Clone)]
pub struct Replay {
    /// The steps with their repetitions, which have no events.
    steps: std::vec::IntoIter<(Step, u32)>,
    /// The seconds of the last step, and its remaining repetitions.
    again: (f32, u32),
}

impl Replay {
    /// Reads a recording. Paths of dropped files are relative to `folder`.
    pub fn parse(text: &str, folder: &Path) -> Result<Self, Malformed> {
        let mut steps = Vec::new();
        let mut events = Vec::new();
        let mut lines = text.lines().enumerate();
        if lines.next().is_none_or(|(_, line)| line.trim_end() != HEADER) {
            return Err(Malformed {
                line: 1,
                why: "not a recording: it does not begin with \"rtrt input 1\"",
            });
        }
        for (index, line) in lines {
            let malformed = |why| Malformed { line: index + 1, why };
            let words: Vec<&str> = line.split_whitespace().collect();
            let (count, seconds) = match words.as_slice() {
                [] => continue,
                [first, ..] if first.starts_with('#') => continue,
                ["frame", seconds] => ("1", seconds),
                ["frames", count, seconds] => (*count, seconds),
                _ => {
                    events.push(match line.parse().map_err(malformed)? {
                        Event::Drop(path) => Event::Drop(folder.join(path)),
                        event => event,
                    });
                    continue;
                }
            };
            let count = count.parse().ok().filter(|count| (1..=10_000_000).contains(count));
            let count = count.ok_or(malformed("not a number of frames"))?;
            let seconds = number(seconds).filter(|seconds| (0.0..=10.0).contains(seconds));
            let seconds = seconds.ok_or(malformed("the seconds are not within 0 and 10"))?;
            steps.push((Step { events: std::mem::take(&mut events), seconds }, count));
        }
        Ok(Self { steps: steps.into_iter(), again: (0.0, 0) })
    }
}

impl Iterator for Replay {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        let (seconds, count) = &mut self.again;
        if *count > 0 {
            *count -= 1;
            return Some(Step { events: Vec::new(), seconds: *seconds });
        }
        let (step, count) = self.steps.next()?;
        self.again = (step.seconds, count - 1);
        Some(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_replay_equals_its_recording() {
        let steps = [
            Step { events: vec![Event::Size([640, 360], 1.25), Event::Focus(true)], seconds: 0.1 },
            Step { events: vec![], seconds: 1.0 / 60.0 },
            Step {
                events: vec![
                    Event::Press(Key::W),
                    Event::Release(Key::PageUp),
                    Event::Press(Key::Num1),
                    Event::Modifiers(Modifiers { ctrl: true, shift: false, alt: true }),
                    Event::Modifiers(Modifiers::default()),
                    Event::Text("a \\ é\n \"x\" ".into()),
                    Event::Paste("/a b/é.hdr\n".into()),
                    Event::Move(-0.1, 1234.567),
                    Event::Leave,
                    Event::Button(Button::Middle, true),
                    Event::Button(Button::Left, false),
                    Event::Wheel(-1.5),
                    Event::Pinch(1.25),
                    Event::Pan(-3.0, 0.5),
                    Event::Drop("/a b/c.glb".into()),
                    Event::Point(Point { text: "tone map".into(), side: Side::Right }),
                    Event::Point(Point { text: "a  b".into(), side: Side::On }),
                ],
                seconds: 0.0,
            },
        ];
        let text = header() + &steps.iter().map(Step::to_string).collect::<String>();
        let replay = Replay::parse(&text, Path::new("elsewhere")).unwrap();
        assert_eq!(replay.collect::<Vec<_>>(), steps);
    }

    #[test]
    fn repeated_frames_have_no_events() {
        let text = "rtrt input 1\n# a comment\n\npress W\nframes 3 0.5\ndrop a.obj\nframe 1\n";
        let steps: Vec<_> = Replay::parse(text, Path::new("in")).unwrap().collect();
        let counts: Vec<_> = steps.iter().map(|step| (step.events.len(), step.seconds)).collect();
        assert_eq!(counts, [(1, 0.5), (0, 0.5), (0, 0.5), (1, 1.0)]);
        assert_eq!(steps[3].events, [Event::Drop("in/a.obj".into())]);
    }

    #[test]
    fn invalid_lines_are_refused_with_their_number() {
        let bad = [
            "",
            "frame",
            "frame x",
            "frame -1",
            "frame nan",
            "frames 0 1",
            "frames -1 1",
            "press",
            "press Foo",
            "press W W",
            "move 1",
            "move 1 inf",
            "size 0 1 1",
            "size 9 9 0",
            "button left",
            "button left x",
            "wheel",
            "pinch 0",
            "pan 1",
            "focus",
            "modifiers super",
            "leave now",
            "text \\u{110000}",
            "drop",
            "point",
            "beside",
            "before",
            "jump 3",
        ];
        for bad in &bad[1..] {
            let refused = Replay::parse(&format!("rtrt input 1\nleave\n{bad}\n"), Path::new("")).unwrap_err();
            assert_eq!(refused.line, 3, "{bad}: {refused}");
        }
        assert_eq!(Replay::parse(bad[0], Path::new("")).unwrap_err().line, 1);
        assert_eq!(Replay::parse("frame 1", Path::new("")).unwrap_err().line, 1);
    }
}
