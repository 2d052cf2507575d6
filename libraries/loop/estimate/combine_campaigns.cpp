#include "loop/estimate/combine_campaigns.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "base/text/words.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::loop {
namespace {

using Indices = std::vector<Eigen::Index>;

/// Rows of the coordinates of anchors.
Indices coordinates_of(const Indices& anchors) {
  Indices rows;
  for (const Eigen::Index a : anchors)
    for (Eigen::Index k = 0; k < 3; ++k) rows.push_back(3 * a + k);
  return rows;
}

Eigen::MatrixXd part(const Eigen::MatrixXd& matrix, const Indices& rows, const Indices& columns) {
  return matrix(coordinates_of(rows), coordinates_of(columns));
}

Eigen::LLT<Eigen::MatrixXd> factor_of(const Eigen::MatrixXd& matrix) {
  Eigen::LLT<Eigen::MatrixXd> factor(matrix);
  if (factor.info() != Eigen::Success)
    throw std::runtime_error(
        "the covariance of the anchors' measured places is not positive definite: no two "
        "campaigns can be compared by it");
  return factor;
}

/// What of the campaign meets what of the estimate: anchors by their places in both.
struct Meeting {
  Indices before, now;
};

/// The statistic that says most of all that something moved, over its critical value.
struct Suspect {
  Indices which;  ///< of the meeting
  MovedAnchor moved;
};

class Comparison {
 public:
  Comparison(const AnchorPlaces& before, const AnchorPlaces& campaign, const Eigen::MatrixXd& drifted,
             const Meeting& meeting) {
    const Indices rows = coordinates_of(meeting.before), now = coordinates_of(meeting.now);
    difference_ = campaign.places(now) - before.places(rows);
    factor_ = factor_of(drifted(rows, rows) + campaign.own(now, now));
    weighted_ = factor_.solve(difference_);
  }

  double chi_squared() const { return difference_.dot(weighted_); }
  const Eigen::LLT<Eigen::MatrixXd>& factor() const { return factor_; }
  const Eigen::VectorXd& weighted() const { return weighted_; }
  const Eigen::VectorXd& difference() const { return difference_; }

 private:
  Eigen::VectorXd difference_, weighted_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

/// What is left of a comparison once what moved is taken out of it, one after the other, the worst first. The inverse
/// covariance of what is left is the Schur complement of what is taken out, so nothing is factorised again.
class Suspects {
 public:
  Suspects(const AnchorPlaces& before, const Comparison& comparison, const Meeting& meeting)
      : before_(before), left_(meeting.before), difference_(comparison.difference()) {
    weights_ = comparison.factor().solve(Eigen::MatrixXd::Identity(difference_.size(), difference_.size()));
  }

  /// Each anchor alone and each floor as a whole, against that nothing moved. Nothing if none is over `critical`.
  Suspect worst(double critical) const {
    const Eigen::VectorXd weighted = weights_ * difference_;
    Suspect worst;
    worst.moved.statistic = critical;
    std::map<int, Indices> floors;
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(left_.size()); ++i) {
      const auto at = static_cast<std::size_t>(left_[i]);
      look_at({i}, before_.ids[at], before_.floors[at], weighted, worst);
      floors[before_.floors[at]].push_back(i);
    }
    for (const auto& [floor, which] : floors)
      if (which.size() >= 3) look_at(which, {}, floor, weighted, worst);
    worst.moved.critical = critical;
    return worst;
  }

  /// Their ids.
  std::set<std::string> take_out(const Indices& which) {
    std::set<std::string> ids;
    Indices kept;
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(left_.size()); ++i)
      if (std::find(which.begin(), which.end(), i) == which.end())
        kept.push_back(i);
      else
        ids.insert(before_.ids[left_[i]]);
    const Indices rows = coordinates_of(kept), out = coordinates_of(which);
    const Eigen::MatrixXd across = weights_(out, rows);
    const Eigen::MatrixXd rest =
        weights_(rows, rows) - across.transpose() * factor_of(weights_(out, out)).solve(across);
    weights_ = 0.5 * (rest + rest.transpose());
    difference_ = Eigen::VectorXd(difference_(rows));
    Indices left;
    for (const Eigen::Index i : kept) left.push_back(left_[i]);
    left_ = std::move(left);
    return ids;
  }

 private:
  /// One shift for all of them: generalised least squares under the hypothesis, and its chi-squared.
  void look_at(const Indices& which, const std::string& id, int floor, const Eigen::VectorXd& weighted,
               Suspect& worst) const {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Eigen::Index a : which) {
      right += weighted.segment<3>(3 * a);
      for (const Eigen::Index b : which) normal += weights_.block<3, 3>(3 * a, 3 * b);
    }
    const Eigen::Vector3d shift = normal.ldlt().solve(right);
    const double statistic = shift.dot(right);
    if (statistic <= worst.moved.statistic) return;
    worst.which = which;
    worst.moved.id = id, worst.moved.floor = floor, worst.moved.shift = shift, worst.moved.statistic = statistic;
  }

  const AnchorPlaces& before_;
  Indices left_;  ///< of the estimate, by place in `weights_`
  Eigen::VectorXd difference_;
  Eigen::MatrixXd weights_;
};

/// Anchors that errors tie together, in the estimate or in the campaign; each group is combined by itself.
std::vector<std::set<std::string>> groups_of(const AnchorPlaces& before, const AnchorPlaces& campaign) {
  std::map<std::string, std::size_t> number;
  for (const AnchorPlaces* places : {&before, &campaign})
    for (const std::string& id : places->ids) number.try_emplace(id, number.size());
  std::vector<std::size_t> root(number.size());
  for (std::size_t i = 0; i < root.size(); ++i) root[i] = i;
  const auto find = [&](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const AnchorPlaces* places : {&before, &campaign})
    for (Eigen::Index a = 0; a < static_cast<Eigen::Index>(places->size()); ++a)
      for (Eigen::Index b = 0; b < a; ++b)
        if (!places->own.block<3, 3>(3 * a, 3 * b).isZero(0))
          root[find(number.at(places->ids[a]))] = find(number.at(places->ids[b]));
  std::map<std::size_t, std::set<std::string>> by_root;
  for (const auto& [id, i] : number) by_root[find(i)].insert(id);
  std::vector<std::set<std::string>> groups;
  for (auto& [i, ids] : by_root) groups.push_back(std::move(ids));
  return groups;
}

AnchorPlaces chosen(const AnchorPlaces& from, const Indices& which) {
  AnchorPlaces out;
  for (const Eigen::Index i : which) {
    const auto at = static_cast<std::size_t>(i);
    out.ids.push_back(from.ids[at]), out.floors.push_back(from.floors[at]), out.campaigns.push_back(from.campaigns[at]);
  }
  out.places = from.places(coordinates_of(which)), out.own = part(from.own, which, which);
  return out;
}

AnchorPlaces chosen(const AnchorPlaces& from, const std::set<std::string>& ids, bool wanted = true) {
  Indices which;
  for (std::size_t i = 0; i < from.size(); ++i)
    if ((ids.count(from.ids[i]) > 0) == wanted) which.push_back(static_cast<Eigen::Index>(i));
  return chosen(from, which);
}

/// All anchors of a storey together, in height, as far as the storeys below them let them.
Eigen::MatrixXd with_drift(const AnchorPlaces& places, double per_storey) {
  Eigen::MatrixXd own = places.own;
  for (std::size_t a = 0; a < places.size(); ++a)
    for (std::size_t b = 0; b < places.size(); ++b)
      if (places.floors[a] == places.floors[b]) {
        const double drift = per_storey * std::max(1, places.floors[a]);
        own(3 * static_cast<Eigen::Index>(a) + 2, 3 * static_cast<Eigen::Index>(b) + 2) += drift * drift;
      }
  return own;
}

Meeting meeting_of(const AnchorPlaces& before, const AnchorPlaces& campaign) {
  std::map<std::string, Eigen::Index> at;
  for (std::size_t i = 0; i < before.size(); ++i) at[before.ids[i]] = static_cast<Eigen::Index>(i);
  Meeting meeting;
  for (std::size_t i = 0; i < campaign.size(); ++i)
    if (const auto found = at.find(campaign.ids[i]); found != at.end())
      meeting.before.push_back(found->second), meeting.now.push_back(static_cast<Eigen::Index>(i));
  return meeting;
}

/// The estimate after the campaign: `before` has nothing that moved, and `campaign` all that is new.
AnchorPlaces fused(const AnchorPlaces& before, const AnchorPlaces& campaign, const Eigen::MatrixXd& drifted,
                   const Meeting& meeting) {
  Indices fresh;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(campaign.size()); ++i)
    if (std::find(meeting.now.begin(), meeting.now.end(), i) == meeting.now.end()) fresh.push_back(i);
  AnchorPlaces out = before;
  out.own = drifted;
  const AnchorPlaces added = chosen(campaign, fresh);
  Eigen::MatrixXd added_own = added.own;
  Eigen::VectorXd added_places = added.places;
  Eigen::MatrixXd across = Eigen::MatrixXd::Zero(out.own.rows(), added_own.rows());
  if (!meeting.before.empty()) {
    const Comparison comparison(before, campaign, drifted, meeting);
    const Indices rows = coordinates_of(meeting.before);
    const Eigen::MatrixXd of_before = drifted(Eigen::all, rows);
    const Eigen::MatrixXd of_fresh = campaign.own(coordinates_of(fresh), coordinates_of(meeting.now));
    const Eigen::MatrixXd gain = comparison.factor().solve(of_before.transpose()).transpose();
    out.places += of_before * comparison.weighted();
    out.own -= gain * of_before.transpose();
    added_places -= of_fresh * comparison.weighted();
    added_own -= of_fresh * comparison.factor().solve(of_fresh.transpose());
    across = gain * of_fresh.transpose();
    for (std::size_t i = 0; i < meeting.before.size(); ++i)
      out.campaigns[meeting.before[i]] += campaign.campaigns[meeting.now[i]];
  }
  const Eigen::Index n = out.places.size(), m = added_places.size();
  Eigen::MatrixXd own(n + m, n + m);
  own.topLeftCorner(n, n) = out.own, own.bottomRightCorner(m, m) = added_own;
  own.topRightCorner(n, m) = across, own.bottomLeftCorner(m, n) = across.transpose();
  out.own = 0.5 * (own + own.transpose());
  out.places.conservativeResize(n + m);
  out.places.tail(m) = added_places;
  out.ids.insert(out.ids.end(), added.ids.begin(), added.ids.end());
  out.floors.insert(out.floors.end(), added.floors.begin(), added.floors.end());
  out.campaigns.insert(out.campaigns.end(), added.campaigns.begin(), added.campaigns.end());
  return out;
}

/// Without what was worked on, and the campaign without what the estimate has of it already.
AnchorPlaces what_is_new(const AnchorPlaces& before, const AnchorPlaces& campaign) {
  std::map<std::string, const std::string*> known;
  for (std::size_t i = 0; i < before.size(); ++i) known[before.ids[i]] = &before.campaigns[i];
  Indices which;
  for (std::size_t i = 0; i < campaign.size(); ++i) {
    const auto found = known.find(campaign.ids[i]);
    if (found == known.end() || found->second->find(campaign.campaigns[i]) == std::string::npos)
      which.push_back(static_cast<Eigen::Index>(i));
  }
  return chosen(campaign, which);
}

/// Ids of what is not where the estimate has it.
std::set<std::string> take_out_what_moved(const AnchorPlaces& before, const AnchorPlaces& campaign,
                                          const Eigen::MatrixXd& drifted, const Meeting& meeting, double critical,
                                          CombinedCampaigns& out) {
  std::set<std::string> moved;
  if (meeting.before.empty()) return moved;
  Suspects suspects(before, Comparison(before, campaign, drifted, meeting), meeting);
  for (;;) {
    const Suspect suspect = suspects.worst(critical);
    if (suspect.which.empty()) return moved;
    out.moved.push_back(suspect.moved);
    moved.merge(suspects.take_out(suspect.which));
  }
}

void combine_group(AnchorPlaces before, const AnchorPlaces& all_of_campaign, double critical,
                   const CombineOptions& options, CombinedCampaigns& out) {
  const AnchorPlaces campaign = what_is_new(before, all_of_campaign);
  // The same readings with a few more: what is measured anew has the errors of what the estimate has already.
  if (!meeting_of(before, campaign).before.empty())
    out.known += static_cast<int>(all_of_campaign.size() - campaign.size());
  Eigen::MatrixXd drifted = with_drift(before, options.drift_per_storey);
  if (campaign.size() == 0) drifted = before.own;
  Meeting meeting = meeting_of(before, campaign);
  if (const std::set<std::string> moved = take_out_what_moved(before, campaign, drifted, meeting, critical, out);
      !moved.empty()) {
    before = chosen(before, moved, false);
    drifted = with_drift(before, options.drift_per_storey);
    meeting = meeting_of(before, campaign);
  }
  if (!meeting.before.empty()) {
    out.compared += static_cast<int>(meeting.before.size());
    out.chi_squared += Comparison(before, campaign, drifted, meeting).chi_squared();
  }
  const AnchorPlaces group = fused(before, campaign, drifted, meeting);
  out.estimate = out.estimate.size() == 0 ? group : fused(out.estimate, group, out.estimate.own, {});
}

}  // namespace

CombinedCampaigns combine_campaigns(const AnchorPlaces& before, const AnchorPlaces& campaign,
                                    const std::set<std::string>& worked_on, const CombineOptions& options) {
  const AnchorPlaces stayed = chosen(before, worked_on, false);
  CombinedCampaigns out;
  const double tests = std::max<double>(1, static_cast<double>(campaign.size()));
  const double critical = chi_squared_quantile(1 - options.false_alarm / tests, 3);
  for (const std::set<std::string>& ids : groups_of(stayed, campaign))
    combine_group(chosen(stayed, ids), chosen(campaign, ids), critical, options, out);
  // Few anchors agree by chance.
  constexpr int kFewest = 4;
  if (out.known > 0 || (out.compared >= kFewest &&
                        out.chi_squared < chi_squared_quantile(options.false_repetition, 3.0 * out.compared))) {
    out.repeats = true;
    out.estimate = campaign;
  }
  return out;
}

std::string repetition_words(const CombinedCampaigns& combined) {
  if (combined.known > 0)
    return "the places of " + std::to_string(combined.known) +
           " anchors are those of a campaign before, to a micrometre, and those of others are not: this campaign holds "
           "readings of that one. Give what was measured since";
  return combined.repeats
             ? fmt::format(
                   "this campaign agrees with those before far better than it can (chi-squared {:.2f} where about {} "
                   "is expected): does it hold readings of theirs, or is the instrument better than its profile? Give "
                   "what was measured since, or a profile as good as the instrument",
                   combined.chi_squared, 3 * combined.compared)
             : std::string();
}

std::vector<std::string> words_of(const CombinedCampaigns& combined) {
  std::vector<std::string> words;
  for (const MovedAnchor& moved : combined.moved) {
    const std::string test = fmt::format(" (test {:.1f}, critical {:.1f})", moved.statistic, moved.critical);
    words.push_back((moved.id.empty() ? "the anchors of floor " + std::to_string(moved.floor) + " are together "
                                      : moved.id + " is ") +
                    text::millimetres(moved.shift.norm()) + " from where campaigns before had " +
                    (moved.id.empty() ? "them" : "it") + test + ": it counts as measured for the first time");
  }
  if (const std::string repeats = repetition_words(combined); !repeats.empty()) words.push_back(repeats);
  return words;
}

}  // namespace plumbline::loop
