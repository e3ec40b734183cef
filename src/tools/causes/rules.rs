//! The rules that a student's tracer breaks.

use serde::Serialize;

/// The kinds of rays that leave surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    Reflected,
    Refracted,
    Shadow,
    /// Towards a light, after crossing a transparent surface.
    Onwards,
}

/// The rays that hit the surface that they leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SelfHitting {
    /// Rays to lights.
    Shadow,
    /// Reflected and refracted rays.
    Secondary,
    /// All rays.
    All,
}

impl SelfHitting {
    /// Returns true if rays of this kind are among these.
    pub fn has(self, kind: RayKind) -> bool {
        match kind {
            RayKind::Shadow => self != Self::Secondary,
            RayKind::Reflected | RayKind::Refracted => self != Self::Shadow,
            RayKind::Onwards => false,
        }
    }
}

/// A broken rule. The table of mistakes describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    AmbientFromAbove,
    AmbientWithoutDiffuse,
    AttenuationTwice,
    BackFacesCulled,
    BackgroundForCameraOnly,
    CheckerboardCut,
    CosineAbsolute,
    DepthAlongAxis,
    DepthInverted,
    DiffuseAbsolute,
    DiffuseNotClamped,
    DiffuseOverPi,
    DirectionsNotNormalised,
    FarHit,
    FirstHit,
    FrontFacesCulled,
    GlassWithoutShadows,
    HalfWayNotNormalised,
    HighlightsByReflection,
    HighlightsByWrongReflection,
    /// Highlights are multiplied by (n + k) / (k pi), with this k.
    HighlightsNormalised(f64),
    HighlightsOnlyWhereLit,
    HighlightsTimesCosine,
    HighlightsTimesDiffuse,
    HighlightsUngated,
    IndexNotInverted,
    LastHit,
    LightsAndAmbientOverwritten,
    LightsClamped,
    LightsOverwritten,
    NoEpsilon(SelfHitting),
    NoiseHalved,
    NoiseSmoothStep,
    NormalFlippedInReflection,
    NormalNotFlippedInRefraction,
    NormalsByInverse,
    NormalsByMatrix,
    NormalsClamped,
    NormalsFlipped,
    NormalsNeverNormalised,
    NormalsNotFlipped,
    NormalsNotNormalised,
    NormalsOfObjectSpace,
    NormalsShifted,
    PointDirectionsNotNormalised,
    RaysClamped,
    ReflectionBlended,
    ReflectionFromBelow,
    ReflectionReversed,
    ReflectionWithoutColor,
    RefractionBlended,
    RefractionWithoutColor,
    SamplesClamped,
    SchlickSwapped,
    /// Shadow rays start this far from the surface along the normal.
    ShadowBias(f64),
    ShadowRaysHalved,
    ShadowsBlack,
    ShadowsFromBehindLight,
    ShadowsHalve,
    ShadowsOfAnyLight,
    ShadowsOfFirstLight,
    SphereNormalsInward,
    SphereNormalsNotNormalised,
    TNotRescaled,
    TotalReflectionAdded,
    TotalReflectionDropped,
    TotalReflectionStraight,
    TriangleNormalsNotNormalised,
    WindingReversed,
    WoodNotSquared,
    WoodRootMissing,
}
