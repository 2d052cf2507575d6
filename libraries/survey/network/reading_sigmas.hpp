// Standard deviations of the readings of a network: of the file, or of the profile of the instrument that took them.
#pragma once

#include <vector>

#include "survey/network/network_model.hpp"

namespace plumbline::survey {

/// What a file gives a standard deviation has its centring in it, unless the file says that it is to be added.
inline bool is_centred_by_profile(const Observation& o) { return std::isnan(o.sigma) || o.without_centring; }

/// The equation of this reading has the centring of its set-up as an unknown.
inline bool has_centring_unknown(const Observation& o, const NetworkProblem& p) {
  return o.set_up >= 0 && is_centred_by_profile(o) && p.centring_blocks[o.set_up] >= 0;
}

class ReadingSigmas {
 public:
  ReadingSigmas(const NetworkModel& model, const AdjustOptions& options, const StochasticState& state);

  /// [rad or m] of a mean observation.
  double operator()(int observation) const;
  /// The instrument's part of it, without centring and heights and without the factor of its group; of a standard
  /// deviation of the file all.
  double own(int observation) const;
  double factor(int observation) const;  ///< of the variance component that it belongs to
  const InstrumentProfile& profile(const Observation& o) const { return profile_of(o, profiles_); }
  Eigen::Vector2d lengths_between(const std::string& from, const std::string& to) const;  ///< horizontal, slope [m]
  /// First, centring [m] of the instruments over the marks of the set-ups; 0 where the point is the instrument itself:
  /// a station that nothing else knows (no sight leads to it, it is occupied once, nobody gave it a place). Second, of
  /// the height noted of it.
  std::vector<Eigen::Vector2d> centrings() const;

 private:
  const InstrumentProfile& profile_of(const Observation& o, const std::vector<InstrumentProfile>& profiles) const;
  double sigma_by(const InstrumentProfile& profile, int observation) const;
  bool takes_part(size_t observation) const { return !m_.dropped[observation] && !state_.removed[observation]; }

  const NetworkModel& m_;
  const AdjustOptions& options_;
  const StochasticState& state_;
  std::vector<InstrumentProfile> profiles_, centred_, own_;  ///< of the survey's instruments, the campaign's last
};

}  // namespace plumbline::survey
