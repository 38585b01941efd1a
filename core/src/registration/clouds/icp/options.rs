//! The variants of ICP: what is paired with what, the weights of pairs, and what is minimised.

use crate::bounds::config;

/// What is minimised.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Metric {
    /// Distances between points (Besl & McKay 1992).
    PointToPoint,
    /// Distances of points from lines through neighbouring points (Censi 2008).
    #[default]
    PointToLine,
    /// Distances between surfaces: each point is certain across its surface and uncertain along it
    /// (Segal et al. 2009).
    SurfaceToSurface,
}

/// Which points of the moving cloud are paired.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Selection {
    /// All of them.
    #[default]
    All,
    /// This many, drawn at random.
    Random {
        /// How many.
        count: usize,
        /// Of the random numbers.
        seed: u64,
    },
    /// This many, with normals spread evenly over all directions: surfaces that face a rare
    /// direction keep most of their points.
    UniformNormals {
        /// How many.
        count: usize,
    },
    /// Those where the surface bends: the neighbours' normals differ by more than this, rad.
    KeyPoints {
        /// The least bend.
        bend: f64,
    },
}

/// How a point finds its partner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Association {
    /// The nearest of the points that the sensor saw in about the same direction; for clouds
    /// without a sensor, as `Nearest`.
    #[default]
    ByBearing,
    /// The nearest, by a k-d tree.
    Nearest,
    /// Of the nearest few, the one nearest to the point's normal (Chen & Medioni 1992).
    AlongNormal,
}

/// The weight of pairs, besides that of the kernel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weighting {
    /// Equal for all.
    #[default]
    Equal,
    /// Smaller the more their normals differ.
    ByNormals,
    /// Smaller the farther they are apart, down to zero at the largest distance.
    ByDistance,
}

/// How the influence of a pair falls with its distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RobustKernel {
    /// Not at all.
    None,
    /// In proportion, from the scale on (Huber 1964).
    Huber,
    /// Ever faster, so distant pairs have none.
    #[default]
    Cauchy,
}

config! {
    /// A form of ICP.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct IcpConfig {
        /// Default: points to lines.
        pub metric: Metric = Metric::default(),
        /// Default: all.
        pub selection: Selection = Selection::default(),
        /// Default: by bearing.
        pub association: Association = Association::default(),
        /// Default: all the same.
        pub weighting: Weighting = Weighting::default(),
        /// Default: Cauchy's.
        pub kernel: RobustKernel = RobustKernel::default(),
        /// Scale of the kernel at the first iteration, m. Default 0.5; larger pulls in worse
        /// starts, and outliers with them.
        pub first_scale: f64 = 0.5,
        /// Scale of the kernel at the end, m: about twice the noise. Default 0.03.
        pub last_scale: f64 = 0.03,
        /// What is left of the scale after an iteration. Default 0.5; larger forgives worse starts
        /// and takes longer.
        pub shrink: f64 = 0.5,
        /// While the scale shrinks, one of so many points is paired: what is pulled in from afar
        /// needs no precision. Default 4; larger is quicker, and misled by less.
        pub coarse_stride: usize = 4,
        /// Pairs farther apart than so many scales of the kernel are rejected. Default 4.
        pub max_scales: f64 = 4.0,
        /// Part of the pairs that is kept, the nearest ones (trimmed ICP). Default 1: all.
        pub kept: f64 = 1.0,
        /// Whether only pairs are kept of which each is the nearest to the other. Default false.
        pub is_mutual: bool = false,
        /// Cosine of the largest angle between surfaces that may be the same. Default 0.5.
        pub min_cosine: f64 = 0.5,
        /// Most iterations. Default 50.
        pub max_iterations: usize = 50,
        /// After a step smaller than this the next one is nothing, m. Default 2e-3: steps on lines
        /// are a tenth of the one before or less, and what noise leaves is as large as that.
        pub shift_tolerance: f64 = 2e-3,
        /// The same, rad. Default 6e-4.
        pub turn_tolerance: f64 = 6e-4,
    }
}

impl IcpConfig {
    /// The best settings for points to points. Points sampled at other places are apart by the
    /// spacing of the points, which a narrow kernel would treat as outliers; and steps become
    /// smaller slowly, so only a very small one is the last.
    #[must_use]
    pub fn point_to_point() -> Self {
        Self {
            metric: Metric::PointToPoint,
            last_scale: 0.15,
            shrink: 0.7,
            coarse_stride: 1,
            shift_tolerance: 3e-4,
            turn_tolerance: 1e-4,
            ..Self::default()
        }
    }
}
