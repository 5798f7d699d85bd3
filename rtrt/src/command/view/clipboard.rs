//! The text that programs copy for one another.
//!
//! A recording holds what was pasted, so a replay needs no clipboard. It does not touch that of the person who runs it.

use arboard::Clipboard as System;

/// The clipboard of the system, opened when it is first used.
#[derive(Default)]
pub struct Clipboard(Option<System>);

impl Clipboard {
    /// Its text; none if there is no text, or no clipboard.
    pub fn text(&mut self) -> Option<String> {
        self.system()?.get_text().ok()
    }

    /// Puts a text there. Nothing happens where there is no clipboard.
    pub fn copy(&mut self, text: String) {
        if let Some(system) = self.system() {
            system.set_text(text).ok();
        }
    }

    fn system(&mut self) -> Option<&mut System> {
        if self.0.is_none() {
            self.0 = System::new().ok();
        }
        self.0.as_mut()
    }
}
