// Spatial mapping between two clouds of SPH particles that move, grow and shrink: consistent for intensities,
// conservative for impulses. Plain arrays in, plain arrays out; time and transport are other people's business.
//
// Consistent: at a target x_i, over all source points j with |x_i - x_j| < 2 h_j, weights w_ij = V_j W(|x_i - x_j|,
// h_j) [x mask_j]. The value is that of the moving-least-squares plane through the neighbours, which is exact for
// linear fields; where the second moment of the neighbours is nearly singular (few points, or points in a line) the
// plane's slope fades out and the weighted mean (Shepard) remains, exact for constants. A plane that would leave the
// range of the neighbours' values is cut at that range. Conservative: the transpose of the Shepard weights by which the
// receivers would be interpolated to the givers, so that every giver's amount is shared out completely. Only active
// points give amounts; a ghost passes what falls to it on to the point it images, so that a wall or a periodic side
// does not skew the shares.
#pragma once

#include "common/core/archive.hpp"
#include "common/core/vector.hpp"
#include "common/coupling/exchange.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace poretwin::coupling {

struct MappingCounts {
  std::uint64_t rebuilds = 0;   ///< pair lists searched anew
  std::uint64_t reuses = 0;     ///< pair lists kept, weights renewed
  std::uint64_t unchanged = 0;  ///< weights kept too: nothing had moved
};

/// Numbers of the linear/Shepard switch, in units of h^2: eigenvalue of the neighbours' covariance below which only the
/// mean is used, and above which the plane is used in full. A whole 2D neighbourhood has 0.22 .. 0.3, a straight row of
/// points 0.
inline constexpr double slope_off = 0.02, slope_full = 0.06;

/// Room added to every support radius, in units of the largest one: lists hold until points have moved that far, taken
/// together.
inline constexpr double relative_skin = 0.15;

/// Balancing of conservative shares: rounds at most, relative unevenness at which they end, and the asymmetry of the
/// givers about a receiver up to which it counts as inside (a flat edge has 0.47, disordered points inside 0.3).
inline constexpr int balancing_rounds = 10;
inline constexpr double balancing_tolerance = 1e-3, inside_asymmetry = 0.31;

/// The pairs (target, source) and their weights, kept from window to window.
template <int D>
class PairWeights {
 public:
  /// Brings pairs and weights up to date: all points of `source`, active points of `target`.
  void update(const PointSet& source, const PointSet& target);

  /// sum_j V_j W at the targets: 1 inside the source's cloud, 0 outside.
  [[nodiscard]] const std::vector<double>& coverage() const { return coverage_; }
  /// |sum_j V_j W (x_j - x)| / (sum_j V_j W h_j) at the targets: 0 inside the source's cloud, 0.47 on its flat edge.
  [[nodiscard]] const std::vector<double>& asymmetry() const { return asymmetry_; }

  /// Interpolates fields of the source to the targets; `mask` (one value per source point) may be empty. Where nothing
  /// is near: 0.
  [[nodiscard]] std::vector<Field> consistent(std::span<const Field* const> fields, std::span<const double> mask) const;

  /// Shares out amounts, from the TARGETS of these pairs (givers) to the active SOURCES (receivers): the transpose.
  struct Delivery {
    std::vector<double> values;  ///< [receivers * components]
    std::vector<double> given, delivered,
        undelivered;  ///< [components] sums; carried + given = delivered + undelivered
  };
  /// `carried` [components]: left from earlier windows; it goes to the receivers in proportion to what they get now.
  [[nodiscard]] Delivery conservative(const Field& amounts, std::span<const double> carried) const;

  [[nodiscard]] const MappingCounts& counts() const { return counts_; }

  /// All of it: lists that are kept decide the order in which sums are taken, and with it their last bits.
  void archive(Archive& archive) {
    archive(counts_, source_order_, target_order_, source_, target_, volume_, h_, target_volume_, first_, index_,
            weight_, near_, n_near_, coefficient_, extrapolates_, coverage_, asymmetry_, receivers_, owner_,
            source_then_, target_then_, h_then_, skin_);
  }

 private:
  [[nodiscard]] bool lists_hold(const PointSet& source, const PointSet& target) const;
  void search(const PointSet& source, const PointSet& target);
  /// Present positions, volumes and lengths in cell order; false when nothing at all has changed since the last time.
  bool gather(const PointSet& source, const PointSet& target);
  void weigh();
  [[nodiscard]] std::vector<double> balance(const Field& amounts) const;

  MappingCounts counts_;
  // Everything below is in cell order: neighbours in space lie close in memory.
  std::vector<Index> source_order_, target_order_;  ///< cell order -> the caller's order
  VecArray<D> source_, target_;                     ///< m, now
  std::vector<double> volume_, h_;                  ///< of the sources, now
  std::vector<double> target_volume_;
  std::vector<Index> first_, index_;  ///< pairs by target
  std::vector<double> weight_;        ///< V_j W(r, h_j) by pair; 0 for those in the skin only
  // Of every target, from first_ on: the n_near_ sources with a weight, and their coefficients without a mask.
  std::vector<Index> near_, n_near_;
  std::vector<double> coefficient_;
  std::vector<char> extrapolates_;            ///< [targets] some coefficient is negative
  std::vector<double> coverage_, asymmetry_;  ///< in the caller's order
  std::size_t receivers_ = 0;                 ///< active sources
  std::vector<std::int64_t> owner_;           ///< of the sources in cell order: the receiver each stands for, or -1
  // As they were when the lists were made, in the caller's order.
  std::vector<double> source_then_, target_then_, h_then_;
  double skin_ = 0.0;  ///< m
};

/// Both directions between the fluid and the solid, dimension erased.
class SpatialMapping {
 public:
  SpatialMapping() = default;
  SpatialMapping(const SpatialMapping&) = delete;
  SpatialMapping& operator=(const SpatialMapping&) = delete;
  virtual ~SpatialMapping() = default;

  /// What was given and got of one conservative field, and what waits.
  struct Account {
    std::string field;
    std::string unit;
    Role giver = Role::fluid;
    std::vector<double> given, delivered, undelivered;  ///< [components] sums over the run; undelivered: waiting now
  };

  /// The giver's fields at the receiver's active points: what the receiver takes, in its order. Conservative fields
  /// update the accounts. Throws PeerError when a field is missing.
  virtual Inbox map(Role giver, const PointSet& giver_points, const std::vector<Field>& giver_fields,
                    std::span<const FieldSpec> specs, const PointSet& receiver_points) = 0;

  [[nodiscard]] virtual MappingCounts counts() const = 0;
  /// Accounts are part of the state of a window: a rejected window puts them back.
  [[nodiscard]] virtual const std::vector<Account>& accounts() const = 0;
  virtual void set_accounts(std::vector<Account> accounts) = 0;
  /// Complete, for a checkpoint.
  virtual void archive(Archive& archive) = 0;
};

std::unique_ptr<SpatialMapping> make_mapping(int dimension);

}  // namespace poretwin::coupling
