//! What a robot feels when it touches something.

/// Which bumpers are pressed.
///
/// The RP6 has two in front; a push from behind presses neither, but counts as contact all the
/// same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bumpers {
    /// Front left.
    pub left: bool,
    /// Front right.
    pub right: bool,
}

impl Bumpers {
    /// Whether any bumper is pressed.
    #[must_use]
    pub fn any(self) -> bool {
        self.left || self.right
    }
}
