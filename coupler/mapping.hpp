// Spatial mapping between two clouds of SPH particles that move, grow and shrink: consistent for intensities,
// conservative for impulses. Input and output are plain arrays; nothing here depends on time or transport.
//
// Consistent: the value at a receiving point x_i is that of the moving-least-squares plane through the giving points j
// with r = |x_i - x_j| < 2 h_j. Their weights are w_ij = V_j W(r, h_j), times mask_j where the field has a mask. The
// value is exact for linear fields. Where the second moment of the neighbours is nearly singular (few points, or points
// in a line), the plane's slope is reduced, down to the weighted mean (Shepard), which is exact for constants only. A
// value out of the range of the neighbours' values is limited to that range.
// Nearest: as consistent, but where the neighbours' values jump the value is that of the point with the largest w_ij: a
// mean over the kernel would make a layer of low permeability thinner by a row on either side.
// Conservative: with the transposed Shepard weights, those of an interpolation from the receivers to the givers, so
// that every giver's amount is distributed completely. Only active points give amounts. A ghost passes what it receives
// to the point of which it is an image, so that a wall or a periodic side does not distort the distribution.
#pragma once

#include "common/core/archive.hpp"
#include "common/coupling/exchange.hpp"
#include "coupler/pair_blocks.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace poretwin::coupling {

/// The field of that name in a publication. Throws PeerError where it is missing.
const Field& field_named(const std::vector<Field>& fields, const std::string& name);

struct MappingCounts {
  std::uint64_t rebuilds = 0;  ///< number of times that pair lists were made anew
  std::uint64_t reuses = 0;    ///< number of times that pair lists were kept
};

/// Limits between plane and mean, in units of h^2, for the smallest eigenvalue of the neighbours' covariance: below
/// slope_off only the mean is used, above slope_full the whole plane. In a complete 2D neighbourhood the eigenvalue is
/// 0.22 .. 0.3, in a straight row of points 0.
inline constexpr double slope_off = 0.02, slope_full = 0.06;

/// A property jumps at a point if its neighbours' values differ by more than this factor, as between two soils. Within
/// one soil such properties change gradually with the porosity, and are interpolated.
inline constexpr double jump = 2.0;

/// Sums of weights up to this are rounding errors: a point at the very rim of the only support counts as uncovered.
inline constexpr double no_weight = 1e-12;

/// Balancing of conservative shares: largest number of rounds; relative unevenness at which they end; largest asymmetry
/// of the givers about a receiver that counts as inside (0.47 at a flat edge, 0.3 between disordered points inside).
inline constexpr int balancing_rounds = 10;
inline constexpr double balancing_tolerance = 1e-3, inside_asymmetry = 0.31;

/// Fields with the same mask, which has one value per giving point, or none.
struct FieldGroup {
  std::vector<const Field*> fields;
  std::span<const double> mask;
  std::vector<const Field*> properties = {};  ///< mapped as `fields`; where they jump, from the nearest giving point
};

/// The giver's fields at the receiver's active points, per group: fields, then properties; 0 without neighbours.
struct Interpolation {
  std::vector<double> coverage;   ///< sum_j V_j W: 1 inside the giver's cloud, 0 outside
  std::vector<double> asymmetry;  ///< |sum_j V_j W (x_j - x)| / (sum_j V_j W h_j): 0 inside, 0.47 on a flat edge
  std::vector<double> spread;     ///< sqrt(trace C) / h, C: covariance of the x_j: 0 of one point, 0.6 on a flat edge
  std::vector<Field> fields;      ///< group by group
};

/// Whether all values are zero.
bool all_zero(const std::vector<double>& values);

/// Consistent mapping. `at_receivers`: blocks of the receiving points, with the giving points around them. Fields that
/// are zero everywhere take no time. `weights`: the weights of the active blocks with the kernels of the giving points,
/// where these have been computed already.
template <int D>
Interpolation consistent(const PairBlocks<D>& at_receivers, std::span<const FieldGroup> groups,
                         const PairWeights* weights = nullptr);

/// Result of distributing amounts.
struct Delivery {
  std::vector<double> values;                         ///< [active receivers * components]
  std::vector<double> given, delivered, undelivered;  ///< sums [components]: carried + given = delivered + undelivered
};

/// Distributes amounts of the active giving points among the active receiving points. Memory is kept between windows;
/// weights are kept as long as no point moves.
template <int D>
class Sharing {
 public:
  /// Distributes `amounts`. `carried` [components]: amounts undelivered in earlier windows, which are distributed in
  /// proportion to what each receiver gets now.
  Delivery conservative(const PairBlocks<D>& at_givers, const PairBlocks<D>& at_receivers, const PointSet& givers,
                        const PointSet& receivers, const Field& amounts, std::span<const double> carried);

  /// The last weights by receivers' kernels at the givers, if they belong to these blocks and nothing has moved since;
  /// else nullptr.
  [[nodiscard]] const PairWeights* weights_at(const PairBlocks<D>& givers) const {
    return weighed_ == &givers && weighed_state_ == givers.state() ? &by_giver_ : nullptr;
  }

 private:
  PairWeights by_giver_, by_receiver_;
  const PairBlocks<D>* weighed_ = nullptr;  ///< blocks to which by_giver_ belongs
  std::uint64_t weighed_state_ = 0;
};

/// Mapping in both directions between the fluid and the solid, in 2D or 3D.
class SpatialMapping {
 public:
  SpatialMapping() = default;
  SpatialMapping(const SpatialMapping&) = delete;
  SpatialMapping& operator=(const SpatialMapping&) = delete;
  virtual ~SpatialMapping() = default;

  /// Balance of one conservative field: amounts given, delivered and still undelivered.
  struct Account {
    std::string field;
    std::string unit;
    Role giver = Role::fluid;
    std::vector<double> given, delivered, undelivered;  ///< [components] totals of the run; undelivered: at present
  };

  /// Maps the giver's fields to the receiver's active points; returns the fields that the receiver takes, in its order.
  /// Updates the accounts of conservative fields. Throws PeerError where a field is missing.
  virtual Inbox map(Role giver, const PointSet& giver_points, const std::vector<Field>& giver_fields,
                    std::span<const FieldSpec> specs, const PointSet& receiver_points) = 0;

  [[nodiscard]] virtual MappingCounts counts() const = 0;
  /// The balances of all conservative fields. They belong to a window's state; a rejected window restores them.
  [[nodiscard]] virtual const std::vector<Account>& accounts() const = 0;
  virtual void set_accounts(std::vector<Account> accounts) = 0;
  /// Writes the accounts to a checkpoint, or reads them from it. Pair lists need not be saved, since they never change
  /// a result.
  virtual void archive(Archive& archive) = 0;
};

std::unique_ptr<SpatialMapping> make_mapping(int dimension);

}  // namespace poretwin::coupling
