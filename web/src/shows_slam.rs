//! What the page asks of an estimate and its map: the same of a simulation, of a recording and of a robot.

/// Gives a class that has a `session()`, `true_walls()`, a `trajectory()` and a `scan_log()` the methods that show, plan in
/// and save them.
macro_rules! shows_slam {
    ($class:ident) => {
        #[wasm_bindgen::prelude::wasm_bindgen]
        impl $class {
            /// The map since `revision` of `generation`, and the last scan.
            #[must_use]
            pub fn view(&self, generation: u32, revision: f64) -> $crate::SlamView {
                $crate::SlamView::since(self.session(), generation, revision)
            }

            /// Why the last scan's lines were matched, and, with `matrix`, how errors hang together; nothing for methods
            /// without a line map.
            #[must_use]
            pub fn inspect(&self, matrix: bool) -> Option<$crate::Inspection> {
                $crate::Inspection::of(self.session(), matrix)
            }

            /// Walls that the last scan showed to be parts of others: the one that stays and the one that goes, pair by
            /// pair.
            #[must_use]
            pub fn merged(&self) -> Vec<u32> {
                $crate::view::merged(self.session().slam())
            }

            /// x1 y1 x2 y2 of the walls of the known map, m; empty for other methods.
            #[must_use]
            pub fn known_walls(&self) -> Vec<f32> {
                $crate::view::known_walls(self.session().slam())
            }

            /// A map to be found in, made of the grid as it is.
            ///
            /// # Errors    A sentence on what is missing in it.
            pub fn as_known(&self) -> Result<$crate::Known, wasm_bindgen::prelude::JsError> {
                $crate::building::known_of_grid(self.session().slam())
            }

            /// Area known to be free, m². Costs more than a step.
            #[must_use]
            pub fn known_area(&self) -> f64 {
                $crate::view::free_area(self.session().slam())
            }

            /// A field of the grid that the pose's sensor draws, in the blocks in which it may have changed since `revision` of `generation`:
            /// `distance` to the nearest wall, `likelihood` of a beam's end, or `room` around the centre of the robot.
            ///
            /// # Errors    There is no such field.
            pub fn field(
                &self,
                name: &str,
                generation: u32,
                revision: f64,
            ) -> Result<$crate::FieldView, wasm_bindgen::prelude::JsError> {
                let (slam, radius) = (self.session().slam(), self.session().robot().radius());
                let field = $crate::FieldView::since(slam, radius, name, generation, revision);
                Ok(field?)
            }

            /// Rooms, corridors and doors of the map, if the grid that the pose's sensor draws has changed since `revision` of
            /// `generation`, as they were told with the last ones. Costs more than a step.
            #[must_use]
            pub fn rooms(&self, generation: u32, revision: f64) -> Option<$crate::Rooms> {
                let (grid, now) = (
                    self.session().slam().grid(),
                    self.session().slam().grid_version() as u32,
                );
                let is_known = now == generation && grid.revision() as f64 == revision;
                (!is_known).then(|| $crate::Rooms::of(grid, now))
            }

            /// All planners from `ends` (x and y of start, of goal, m) for `seconds` each: among the true walls (`truth`), where there
            /// are any, on the map (`map`, the unknown taken to be free) or only where it is known (`known`).
            ///
            /// # Errors    A sentence on start, goal or ground that cannot be.
            #[allow(
                clippy::needless_pass_by_value,
                reason = "lists cross the border by value only"
            )]
            pub fn contest(
                &self,
                ground: &str,
                ends: Vec<f64>,
                seconds: f64,
            ) -> Result<$crate::WebContest, wasm_bindgen::prelude::JsError> {
                let on = $crate::contest::Ground {
                    slam: self.session().slam(),
                    walls: self.true_walls(),
                    robot: self.session().robot(),
                };
                $crate::WebContest::on(on, ground, &ends, seconds)
            }

            /// Half length and half width of the robot, m; 1 where walls are touched by that rectangle, 0 where by the disc around it.
            #[must_use]
            pub fn body(&self) -> Vec<f64> {
                $crate::view::body(self.session().robot())
            }

            /// Files to save, named after `stem`: `map`, `map-scale`, `map-raw`, `og-map`, `plan`, `rooms`, `tum` or `carmen`.
            ///
            /// # Errors    A sentence on why there is no such file.
            pub fn export(
                &self,
                what: &str,
                stem: &str,
            ) -> Result<$crate::Files, wasm_bindgen::prelude::JsError> {
                match what {
                    "tum" => $crate::Files::trajectory(&self.trajectory(), stem),
                    "carmen" => $crate::Files::carmen(&*self.scan_log()?, stem),
                    _ => $crate::Files::of(self.session().slam(), what, stem),
                }
            }
        }
    };
}

pub(crate) use shows_slam;
