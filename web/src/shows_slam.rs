//! What the page asks of an estimate and its map: the same of a simulation, of a recording and of a robot.

/// Gives a class that has a `slam()` the methods that show it.
macro_rules! shows_slam {
    ($class:ident) => {
        #[wasm_bindgen::prelude::wasm_bindgen]
        impl $class {
            /// The map since `revision` of `generation`, and the last scan.
            #[must_use]
            pub fn view(&self, generation: u32, revision: f64) -> $crate::SlamView {
                $crate::SlamView::since(self.slam(), generation, revision)
            }

            /// Why the last scan's lines were matched, and, with `matrix`, how errors hang together; nothing for methods
            /// without a line map.
            #[must_use]
            pub fn inspect(&self, matrix: bool) -> Option<$crate::Inspection> {
                $crate::Inspection::of(self.slam(), matrix)
            }

            /// Walls that the last scan showed to be parts of others: the one that stays and the one that goes, pair by
            /// pair.
            #[must_use]
            pub fn merged(&self) -> Vec<u32> {
                $crate::view::merged(self.slam())
            }

            /// Area known to be free, m². Costs more than a step.
            #[must_use]
            pub fn known_area(&self) -> f64 {
                $crate::view::free_area(self.slam())
            }

            /// The grid as files of map_server, whose YAML names the picture `image`.
            ///
            /// # Errors    An empty map.
            pub fn map_files(
                &self,
                image: &str,
            ) -> Result<$crate::MapFiles, wasm_bindgen::prelude::JsError> {
                $crate::MapFiles::of(self.slam(), image)
            }

            /// The walls as files of drawing programs.
            ///
            /// # Errors    No walls: none were seen often enough, or the method knows none.
            pub fn floor_plan(&self) -> Result<$crate::FloorPlan, wasm_bindgen::prelude::JsError> {
                $crate::FloorPlan::of(self.slam())
            }
        }
    };
}

pub(crate) use shows_slam;
