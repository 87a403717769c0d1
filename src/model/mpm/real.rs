//! Numbers of one precision, with the vectors and matrices of them.
use glam::{DMat3, DVec3, Mat3, Vec3};
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use wide::{f32x4, f64x4};

/// What a control step is computed in: f64 or f32.
#[rustfmt::skip]
pub(super) trait Real:
    Copy + Debug + PartialOrd + Send + Sync + 'static + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
    + Div<Output = Self> + Neg<Output = Self> + AddAssign + SubAssign
{
    type Vector: Vector<Self>;
    type Matrix: Matrix<Self>;
    type Quad: Quad<Self>;
    const ZERO: Self;
    const ONE: Self;
    /// The least normal number.
    const LEAST: Self;
    /// Sweeps of rotations after which what is left off a diagonal is about rounding. In a fourth one, f32 would square what is
    /// left to less than its least normal number, at twice the time of three.
    const SWEEPS: usize;
    /// The nearest to x.
    fn of(x: f64) -> Self;
    fn wide(self) -> f64;
    fn abs(self) -> Self;
    fn atanh(self) -> Self;
    fn copysign(self, sign: Self) -> Self;
    fn ln(self) -> Self;
    fn recip(self) -> Self;
    fn sinh(self) -> Self;
    fn sqrt(self) -> Self;
}

/// Three coordinates; products and quotients go coordinate by coordinate.
#[rustfmt::skip]
pub(super) trait Vector<R: Real>:
    Copy + Debug + Send + Sync + 'static + Add<Output = Self> + Add<R, Output = Self> + Sub<Output = Self>
    + Sub<R, Output = Self> + Mul<Output = Self> + Mul<R, Output = Self> + Div<Output = Self> + Div<R, Output = Self>
    + AddAssign + AddAssign<R>
{
    fn new(array: [R; 3]) -> Self;
    fn to_array(self) -> [R; 3];
    fn dot(self, other: Self) -> R;
    fn element_sum(self) -> R;
    fn exp(self) -> Self;
    fn length(self) -> R;

    /// The nearest to v.
    #[inline]
    fn of(v: DVec3) -> Self {
        Self::new(v.to_array().map(R::of))
    }

    #[inline]
    fn wide(self) -> DVec3 {
        DVec3::from_array(self.to_array().map(R::wide))
    }
}

/// Three columns.
#[rustfmt::skip]
pub(super) trait Matrix<R: Real>:
    Copy + Debug + Send + Sync + 'static + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
    + Mul<R, Output = Self>
{
    const IDENTITY: Self;
    fn new(columns: [R::Vector; 3]) -> Self;
    fn columns(self) -> [R::Vector; 3];
    fn transpose(self) -> Self;

    /// The nearest to m.
    #[inline]
    fn of(m: DMat3) -> Self {
        Self::new([m.x_axis, m.y_axis, m.z_axis].map(R::Vector::of))
    }

    #[inline]
    fn wide(self) -> DMat3 {
        let [x, y, z] = self.columns().map(R::Vector::wide);
        DMat3::from_cols(x, y, z)
    }

    /// Entries, column by column.
    #[inline]
    fn entries(self) -> [[R; 3]; 3] {
        self.columns().map(R::Vector::to_array)
    }
}

/// Four numbers that are added and multiplied at once.
#[rustfmt::skip]
pub(super) trait Quad<R: Real>:
    Copy + Debug + Send + Sync + 'static + Add<Output = Self> + Mul<Output = Self> + AddAssign
{
    const ZERO: Self;
    fn new(array: [R; 4]) -> Self;
    fn to_array(self) -> [R; 4];
    fn splat(x: R) -> Self;
    /// `self a + b`, rounded once.
    fn mul_add(self, a: Self, b: Self) -> Self;
    fn reduce_add(self) -> R;
}

/// The traits of a precision, which hand on to methods of the same names, and for how many sweeps.
macro_rules! precision {
    ($real:ident, $vector:ident, $matrix:ident, $quad:ident, $sweeps:literal) => {
        impl Real for $real {
            type Vector = $vector;
            type Matrix = $matrix;
            type Quad = $quad;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const LEAST: Self = $real::MIN_POSITIVE;
            const SWEEPS: usize = $sweeps;
            precision! { $real:
                fn abs(self) -> Self;
                fn atanh(self) -> Self;
                fn copysign(self, sign: Self) -> Self;
                fn ln(self) -> Self;
                fn recip(self) -> Self;
                fn sinh(self) -> Self;
                fn sqrt(self) -> Self;
            }

            #[inline]
            fn of(x: f64) -> Self {
                x as Self
            }

            #[inline]
            fn wide(self) -> f64 {
                f64::from(self)
            }
        }

        impl Vector<$real> for $vector {
            precision! { $vector:
                fn dot(self, other: Self) -> $real;
                fn element_sum(self) -> $real;
                fn exp(self) -> Self;
                fn length(self) -> $real;
            }

            #[inline]
            fn new(array: [$real; 3]) -> Self {
                Self::from_array(array)
            }

            #[inline]
            fn to_array(self) -> [$real; 3] {
                self.into()
            }
        }

        impl Matrix<$real> for $matrix {
            const IDENTITY: Self = $matrix::IDENTITY;

            #[inline]
            fn new([x, y, z]: [$vector; 3]) -> Self {
                Self::from_cols(x, y, z)
            }

            #[inline]
            fn columns(self) -> [$vector; 3] {
                [self.x_axis, self.y_axis, self.z_axis]
            }

            #[inline]
            fn transpose(self) -> Self {
                $matrix::transpose(&self)
            }
        }

        impl Quad<$real> for $quad {
            const ZERO: Self = $quad::ZERO;
            precision! { $quad:
                fn to_array(self) -> [$real; 4];
                fn mul_add(self, a: Self, b: Self) -> Self;
                fn reduce_add(self) -> $real;
            }

            #[inline]
            fn new(array: [$real; 4]) -> Self {
                $quad::new(array)
            }

            #[inline]
            fn splat(x: $real) -> Self {
                $quad::splat(x)
            }
        }
    };
    ($type:ident: $(fn $method:ident(self $(, $argument:ident: $given:ty)*) -> $result:ty;)*) => {
        $(#[inline]
        fn $method(self $(, $argument: $given)*) -> $result {
            $type::$method(self $(, $argument)*)
        })*
    };
}

precision!(f64, DVec3, DMat3, f64x4, 4);
precision!(f32, Vec3, Mat3, f32x4, 3);
