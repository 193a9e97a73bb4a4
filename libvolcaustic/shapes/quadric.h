// A quadric with deviation functions in world space (VD equations (1) and (2)).
#pragma once

#include "core/hash.h"
#include "shapes/batch.h"
#include "shapes/interval.h"
#include "shapes/symmetric.h"
#include "volcaustic/shape.h"

#include <cstdint>
#include <span>
#include <vector>

namespace volcaustic {

/// q(p) = d.(A d) + b.d + c, where d = p - origin: about a point near to what matters, digits are not lost far from the
/// world's origin.
struct QuadraticForm {
  Vec3d origin{0, 0, 0};
  Symmetric3 a{};
  Vec3d b{0, 0, 0};
  double c = 0;
};

/// The form of a quadric's kind, endless, as shape.h gives it, in the node's own space.
QuadraticForm quadraticForm(const shapes::Kind& kind);
/// Of the same surface placed by `toWorld`.
QuadraticForm placedForm(const QuadraticForm& local, const Affine& toWorld);

/// F = q + sum of w max(0, q_i)^3 made like a distance: D = F / (|grad F|^4 + l^2 F^2)^(1/4), l being the greatest
/// curvature of q (the spectral norm of A). On the surface D = F/|grad F|, Taubin's first-order distance; unlike that
/// it has no pole where the gradient vanishes: in the middle of a sphere it is the radius.
class PlacedQuadric {
public:
  PlacedQuadric(const QuadraticForm& form, const std::vector<QuadraticForm>& regions,
                const std::vector<double>& weights);

  [[nodiscard]] std::size_t deviationCount() const { return mRegions.size(); }
  /// \param active the deviations that are not zero all over, in order
  void evaluate(const ShapePoints& pWorld, std::span<const std::uint32_t> active, const ShapeValues& values) const;
  [[nodiscard]] Interval bound(const Box& world, std::span<const std::uint32_t> active) const;
  /// Whether deviation `i` is zero all over the box.
  [[nodiscard]] bool vanishes(std::uint32_t i, const Box& world) const;
  void addTo(Hash& hash, std::span<const std::uint32_t> active) const;

private:
  QuadraticForm mForm;
  double mCurvature; // l
  struct Region {
    QuadraticForm form;
    double weight;
    double greatest; ///< value of the form, where it has one: roundings far outside do not count for more
  };
  std::vector<Region> mRegions;
};

} // namespace volcaustic
