// Spatial mapping between two clouds of SPH particles that move, grow and shrink: consistent for intensities,
// conservative for impulses. Plain arrays in, plain arrays out; nothing here knows time or transport.
//
// Consistent: at a target x_i, over all source points j with |x_i - x_j| < 2 h_j, weights w_ij = V_j W(|x_i - x_j|,
// h_j) [x mask_j]. The value is that of the moving-least-squares plane through the neighbours, which is exact for
// linear fields; where the second moment of the neighbours is nearly singular (few points, or points in a line) the
// plane's slope fades out and the weighted mean (Shepard) remains, exact for constants. A plane that would leave the
// range of the neighbours' values is cut at that range. Nearest: as consistent, but where the values of the neighbours
// jump, the value of the source point of the largest w_ij: a mean over the kernel would shorten a tight layer by a row
// on either side. Conservative: the transpose of the Shepard weights by which the receivers would be interpolated to
// the givers, so that every giver's amount is shared out completely. Only active points give amounts; a ghost passes
// what falls to it on to the point it images, so that a wall or a periodic side does not skew the shares.
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
  std::uint64_t rebuilds = 0;  ///< pair lists searched anew
  std::uint64_t reuses = 0;    ///< pair lists kept
};

/// Numbers of the linear/Shepard switch, in units of h^2: eigenvalue of the neighbours' covariance below which only the
/// mean is used, and above which the plane is used in full. A whole 2D neighbourhood has 0.22 .. 0.3, a straight row of
/// points 0.
inline constexpr double slope_off = 0.02, slope_full = 0.06;

/// A property jumps at a point if its neighbours' values differ by more than this factor, as between two soils. Within
/// one soil such properties vary with the porosity, and are interpolated as it is.
inline constexpr double jump = 2.0;

/// Sums of weights up to this are rounding noise: a target at the very rim of one support counts as uncovered.
inline constexpr double no_weight = 1e-12;

/// Balancing of conservative shares: rounds at most, relative unevenness at which they end, and the asymmetry of the
/// givers about a receiver up to which it counts as inside (a flat edge has 0.47, disordered points inside 0.3).
inline constexpr int balancing_rounds = 10;
inline constexpr double balancing_tolerance = 1e-3, inside_asymmetry = 0.31;

/// Fields that share a mask: one value per giving point, or none.
struct FieldGroup {
  std::vector<const Field*> fields;
  std::span<const double> mask;
  std::vector<const Field*> properties = {};  ///< mapped as `fields`, but the giver's nearest point's where they jump
};

/// The giver's fields at the receiver's active points, properties after fields; where nothing is near: 0.
struct Interpolation {
  std::vector<double> coverage;   ///< sum_j V_j W: 1 inside the giver's cloud, 0 outside
  std::vector<double> asymmetry;  ///< |sum_j V_j W (x_j - x)| / (sum_j V_j W h_j): 0 inside, 0.47 on its flat edge
  std::vector<Field> fields;      ///< group by group
};

/// Whether all values are zero, so that nothing need be mapped; ends at the first that is not.
bool all_zero(const std::vector<double>& values);

/// Consistent mapping. `at_receivers`: blocks over the receivers, with the givers around them. Fields that are zero
/// everywhere cost nothing. `weights`: weights of the active blocks by the givers' kernels, if there are any already.
template <int D>
Interpolation consistent(const PairBlocks<D>& at_receivers, std::span<const FieldGroup> groups,
                         const PairWeights* weights = nullptr);

/// Amounts that were shared out.
struct Delivery {
  std::vector<double> values;                         ///< [active receivers * components]
  std::vector<double> given, delivered, undelivered;  ///< [components]; carried + given = delivered + undelivered
};

/// Shares amounts of the active givers out among the active receivers. Memory is kept from window to window, and
/// weights as long as no point moves.
template <int D>
class Sharing {
 public:
  /// Shares out `amounts`. `carried` [components]: left from earlier windows; it goes to the receivers in proportion to
  /// what they get now.
  Delivery conservative(const PairBlocks<D>& at_givers, const PairBlocks<D>& at_receivers, const PointSet& givers,
                        const PointSet& receivers, const Field& amounts, std::span<const double> carried);

  /// The last weights of the givers at the receivers, if they were made for these blocks and nothing has moved since;
  /// otherwise null.
  [[nodiscard]] const PairWeights* weights_at(const PairBlocks<D>& givers) const {
    return weighed_ == &givers && weighed_state_ == givers.state() ? &by_giver_ : nullptr;
  }

 private:
  PairWeights by_giver_, by_receiver_;
  const PairBlocks<D>* weighed_ = nullptr;  ///< whose by_giver_ are
  std::uint64_t weighed_state_ = 0;
};

/// Mapping in both directions between the fluid and the solid, for either dimension.
class SpatialMapping {
 public:
  SpatialMapping() = default;
  SpatialMapping(const SpatialMapping&) = delete;
  SpatialMapping& operator=(const SpatialMapping&) = delete;
  virtual ~SpatialMapping() = default;

  /// Amounts of one conservative field that were given and delivered, and that are still undelivered.
  struct Account {
    std::string field;
    std::string unit;
    Role giver = Role::fluid;
    std::vector<double> given, delivered, undelivered;  ///< [components] sums over the run; undelivered: waiting now
  };

  /// Maps the giver's fields to the receiver's active points: the fields that the receiver takes, in its order.
  /// Conservative fields update the accounts. Throws PeerError when a field is missing.
  virtual Inbox map(Role giver, const PointSet& giver_points, const std::vector<Field>& giver_fields,
                    std::span<const FieldSpec> specs, const PointSet& receiver_points) = 0;

  [[nodiscard]] virtual MappingCounts counts() const = 0;
  /// Accounts are part of the state of a window: they are restored with a rejected one.
  [[nodiscard]] virtual const std::vector<Account>& accounts() const = 0;
  virtual void set_accounts(std::vector<Account> accounts) = 0;
  /// Writes or reads the accounts for a checkpoint; lists need not be kept, since they never change a result.
  virtual void archive(Archive& archive) = 0;
};

std::unique_ptr<SpatialMapping> make_mapping(int dimension);

}  // namespace poretwin::coupling
