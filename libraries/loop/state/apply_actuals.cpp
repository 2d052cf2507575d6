// What robots and people report: what is taken of it, and why the rest is not.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/text/bare_name.hpp"
#include "base/text/words.hpp"
#include "loop/fit/facade.hpp"
#include "loop/state/copied_places.hpp"
#include "loop/state/date.hpp"
#include "loop/state/hash.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/place_doubts.hpp"
#include "loop/state/recalled_orders.hpp"
#include "loop/state/report_order.hpp"
#include "loop/state/transitions.hpp"

namespace plumbline::loop {

namespace {

/// A report may come from a tool that stands on the plate, not on the anchor [m].
constexpr double kReach = 0.25;
/// A setting that is reported farther than this from what was asked is not in metres, or of another item [m].
constexpr double kSettingReach = 0.03;
/// A panel that was measured within this of where its centre is to be hangs there [m].
constexpr double kPanelReach = 0.05;
/// By a place less precise than a quarter of that it could hang beyond it, too [m].
constexpr double kLargestSeen = kPanelReach / 4;
/// A standard deviation above this shows of no place where it is, and one below that no instrument of a site has [m].
constexpr double kLargestSigma = 0.05, kLeastSigma = 1e-5;

std::string date_doubt(const LoopItemT& item, const ActualT& actual) {
  if (actual.at.empty()) return {};
  const std::optional<double> then = seconds_of(actual.at);
  if (!then)
    return "is dated '" + actual.at +
           "', expected ISO 8601 with a zone, such as 2026-05-02T08:00:00Z; mend the date and report it again";
  const std::optional<double> released = seconds_of(item.at);
  return released && *then <= *released
             ? "is dated " + actual.at + ", not after the item was released or reported last at " + item.at +
                   "; mend the clock or the date and report it again"
             : std::string();
}

/// A robot whose clock is ahead, or another zone: no campaign would ever be later than such work.
std::string future_doubt(const ActualT& actual, const std::string& now) {
  const std::optional<double> then = seconds_of(actual.at), here = seconds_of(now);
  return then && here && *then > *here ? "is dated " + actual.at + ", later than this round, which is said to be at " +
                                             now + ": mend the clock of who reports, or 'now', and report it again"
                                       : std::string();
}

/// What a panel's place is compared by: a thousand times too large, it would agree with everything.
std::string sigma_doubt(const ActualT& actual) {
  if (actual.sigma.array().isNaN().all()) return {};
  const double least = actual.sigma.minCoeff(), most = actual.sigma.maxCoeff();
  if (!actual.sigma.allFinite() || !(least > 0))
    return fmt::format(
        "has the sigma {:g}, {:g}, {:g}; expected three standard deviations in metres, each above 0; "
        "mend them and report it again",
        actual.sigma.x(), actual.sigma.y(), actual.sigma.z());
  const auto words = [](double sigma, const char* why) {
    return fmt::format("has a sigma of {:g} m, {}; give standard deviations in metres and report it again", sigma, why);
  };
  if (most > kLargestSigma)
    return words(most, 1e-3 * most <= kLargestSigma && 1e-3 * least >= kLeastSigma
                           ? "by which it could be anywhere; that would fit if it is in millimetres"
                           : "by which it could be anywhere");
  if (least < kLeastSigma)
    return words(least, std::sqrt(most) <= kLargestSigma && std::sqrt(least) >= kLeastSigma
                            ? "which no instrument has; that would fit if it is a variance"
                            : "which no instrument has");
  return {};
}

/// What is wrong with a report whatever it is on.
std::string doubt_of_itself(const ActualT& actual, const std::string& now) {
  const std::string doubt = future_doubt(actual, now);
  return doubt.empty() ? sigma_doubt(actual) : doubt;
}

/// A report on work that was released before, or on another robot's, does not say that this was done.
std::string release_doubt(const LoopItemT& item, const ActualT& actual) {
  if (item.kind == "panel" && actual.revision == 0 && actual.job.empty() && actual.at.empty())
    return "has no revision, no job and no date: nothing says that the panel was hung since it was released; give one";
  if (actual.job.empty() || item.jobs.empty()) return {};
  if (std::find(item.jobs.begin(), item.jobs.end(), actual.job) != item.jobs.end()) return {};
  return "answers " + actual.job + ", the item was released with " + item.jobs.back() +
         ": another job was executed; measure the item";
}

std::string setting_doubt(const LoopItemT& item, const ActualT& actual) {
  if (item.kind != "bracket" || !actual.setting.allFinite()) return {};
  const double off = (actual.setting - item.pending).cwiseAbs().maxCoeff();
  if (off <= kSettingReach) return {};
  const bool fits = (1e-3 * actual.setting - item.pending).cwiseAbs().maxCoeff() <= kSettingReach;
  return "its setting is " + text::millimetres(off) + " from what was asked for" +
         (fits ? "; that would fit if it is in millimetres; give metres and report it again" : "; measure the item");
}

bool is_over(const LoopItemT& item) {
  return item.status == ItemStatus::executed || item.status == ItemStatus::relocalised ||
         item.status == ItemStatus::verified;
}

/// Dated before the report that counts, or as old: what it tells of was over by then.
bool is_of_before(const LoopItemT& item, const ActualT& actual) {
  const std::optional<double> then = seconds_of(actual.at), last = seconds_of(item.at);
  return then && last && *then <= *last;
}

/// Whether a report tells of the release that its item has, and not of one before: by revision, job or date.
bool is_of_release(const LoopItemT& item, const ActualT& actual) {
  if (item.revision == 0) return false;
  if (actual.revision != 0) return actual.revision == item.revision;
  if (std::find(item.jobs.begin(), item.jobs.end(), actual.job) != item.jobs.end()) return true;
  return actual.job.empty() && seconds_of(actual.at) && seconds_of(item.at) && !is_of_before(item, actual);
}

/// That a panel hangs is known by reports alone: where they contradict each other somebody looks.
bool contradicts(const LoopItemT& item, const ActualT& actual) {
  return item.kind == "panel" && is_over(item) && is_of_release(item, actual) && !is_of_before(item, actual) &&
         (actual.outcome == "failed" || actual.outcome == "skipped");
}

/// Whether a report shows that its panel hangs: it was measured there, and not by copying the target.
bool shows_panel(const LoopItemT& item, const ActualT& actual, const CopiedPlaces& copied) {
  if (!actual.measured.allFinite() || !item.expected.allFinite()) return false;
  if (actual.sigma.allFinite() && actual.sigma.maxCoeff() > kLargestSeen) return false;
  return !copied.contains(actual) && (actual.measured - item.expected).cwiseAbs().maxCoeff() <= kPanelReach;
}

/// Why the place of a report that is taken does not show that its panel hangs; empty if it does, or there is none.
std::string no_proof(const LoopItemT& item, const ActualT& actual, const CopiedPlaces& copied) {
  if (item.kind != "panel" || item.seen || !actual.measured.allFinite() || !item.expected.allFinite()) return {};
  const bool is_coarse = actual.sigma.allFinite() && actual.sigma.maxCoeff() > kLargestSeen;
  const std::string how =
      copied.contains(actual) ? copied.words(actual)
      : is_coarse ? fmt::format("has a sigma of {:.1f} mm, 12.5 mm at most show it", 1e3 * actual.sigma.maxCoeff())
                  : fmt::format("lies {:.0f} mm from where it should be, {:.0f} mm along an axis show it",
                                1e3 * (actual.measured - item.expected).norm(), 1e3 * kPanelReach);
  return "taken as done, but its place does not show that it hangs: it " + how +
         "; measure it again, or accept it when somebody has seen it";
}

/// The place of a panel with its standard deviations, 0 where none are stated, for whoever compares it with where its
/// brackets say that it hangs.
std::vector<double> place_of_report(const ActualT& actual) {
  if (!actual.measured.allFinite()) return {};
  const bool is_stated = actual.sigma.allFinite() && actual.sigma.minCoeff() > 0;
  const Eigen::Vector3d sigma = is_stated ? actual.sigma : Eigen::Vector3d(0, 0, 0);
  return {actual.measured.x(), actual.measured.y(), actual.measured.z(), sigma.x(), sigma.y(), sigma.z()};
}

/// A later report that shows a panel of which only a word was known so far. One that nothing ties to this release may
/// be of the time before it was taken down and hung again.
bool shows_what_was_reported(const LoopItemT& item, const ActualT& actual, const CopiedPlaces& copied,
                             const std::string& now) {
  return doubt_of_itself(actual, now).empty() && item.kind == "panel" && is_over(item) && item.hangs && !item.seen &&
         actual.outcome == "done" && (actual.revision == 0 || actual.revision == item.revision) &&
         shows_panel(item, actual, copied) && date_doubt(item, actual).empty() && release_doubt(item, actual).empty();
}

/// With the one whose name differs in case, separators or leading zeros alone.
std::string unknown_words(const LoopStateT& state, const std::string& name) {
  const std::string bare = text::bare_name(name);
  std::vector<std::string> alike;
  for (const auto& item : state.items)
    if (text::bare_name(item->id) == bare) alike.push_back(item->id);
  return "no bracket or panel of this name is known" +
         (alike.size() == 1 ? "; but for case, separators or leading zeros it is " + alike[0] : "") +
         "; give the name as it is in the job, or measure the item";
}

/// Nobody needs a job to say that a place of a sill was knocked.
bool says_sill_was_knocked(const LoopItemT& item, const ActualT& actual, const std::string& now) {
  return !item.holds.empty() && actual.outcome == "failed" && item.status == ItemStatus::planned &&
         doubt_of_itself(actual, now).empty() && date_doubt(item, actual).empty();
}

/// ": " and what else a report says.
std::string note_of(const ActualT& actual) { return actual.note.empty() ? "" : ": " + actual.note; }

/// The hash of the file that a report was read from; of one that was read from none, of itself.
std::string digest_of(const ActualT& actual) {
  if (!actual.digest.empty()) return actual.digest;
  return sha256_hex(actual.item + "\n" + actual.job + "\n" + std::to_string(actual.revision) + "\n" + actual.by + "\n" +
                    actual.at + "\n" + actual.outcome);
}

Because by_report(const ActualT& actual, std::string why, const std::string& now) {
  const std::string who = actual.by.empty() ? "not said in the report" : actual.by;
  return {std::move(why), actual.by, actual.at, {digest_of(actual)}, ItemReason::other, who, now};
}

void take_knock(LoopStateT& state, LoopItemT& sill, const ActualT& actual, const std::string& now) {
  const Because because = by_report(actual, "reported failed" + note_of(actual), now);
  reject_item(state, sill, because);
  sill.expected.setConstant(kUnknown);
  reject_what_stands_on(state, sill, by_report(actual, "was " + because.why, now));
}

/// "report on F01-P02 by robot-1 (robot_a.json: items[4]): ".
std::string words_of(const ActualT& actual) {
  return "report on " + actual.item +
         (actual.by.empty() || actual.source.starts_with(actual.by + ":") ? "" : " by " + actual.by) +
         (actual.source.empty() ? "" : " (" + actual.source + ")") + ": ";
}

void take_done(LoopStateT& state, LoopItemT& item, const ActualT& actual, const CopiedPlaces& copied,
               const Because& because) {
  move(state, item, ItemStatus::executed, because);
  // What is asked for stays: the next measurement judges by it, and corrects what the bracket has used of its range.
  item.setting += item.pending, item.hangs = item.kind == "panel";
  item.seen = item.hangs && shows_panel(item, actual, copied);
  item.place = item.seen ? place_of_report(actual) : std::vector<double>();
  item.at = actual.at;  // of the work, not of its release: none is none
}

/// Why a report that a panel does not hang any more is not taken. One of the time before it was hung again would have
/// it hung twice.
std::string removal_doubt(const LoopItemT& item, const ActualT& actual, const std::string& now) {
  if (const std::string doubt = doubt_of_itself(actual, now); !doubt.empty()) return doubt;
  if (item.kind != "panel") return "says removed, which is said of a panel that hung; of a bracket say failed";
  if (!item.hangs) return "says removed, and by what was reported it does not hang; nothing changes";
  if (!is_of_release(item, actual))
    return "says removed, and neither revision, job nor date say that this was after it was hung last; give one of "
           "them as they are in the job";
  return date_doubt(item, actual);
}

bool is_removal(const ActualT& actual) { return actual.outcome == "removed"; }

/// Nobody knows whether it hangs: neither of the two reports is better than the other.
void take_contradiction(LoopStateT& state, LoopItemT& panel, const ActualT& actual, const std::string& now) {
  const bool has_date = seconds_of(actual.at) && future_doubt(actual, now).empty();
  Because because =
      by_report(actual, "reported done, then " + actual.outcome + ", look whether it hangs" + note_of(actual), now);
  if (!has_date) because.at.clear();
  because.reason = ItemReason::look;
  reject_item(state, panel, because);
  panel.seen = false;
}

/// Why a report is not taken; empty if it is.
std::string objection(const LoopItemT* item, const ActualT& actual, const std::string& now) {
  if (is_removal(actual)) return removal_doubt(*item, actual, now);
  if (actual.outcome != "done" && actual.outcome != "failed" && actual.outcome != "skipped")
    return "outcome '" + actual.outcome +
           "', expected done, failed, skipped or removed; say one of them and report it again";
  if (const std::string doubt = doubt_of_itself(actual, now); !doubt.empty()) return doubt;
  if (!item->holds.empty() && item->revision == 0)
    return "is a place of a sill: nobody is asked to set it, and it was not reported as 'failed', which says that it "
           "was "
           "knocked";
  if (is_over(*item) && actual.revision == item->revision)
    return actual.outcome == "done"      ? "was reported before; nothing changes"
           : is_of_before(*item, actual) ? date_doubt(*item, actual)
                                         : "says " + actual.outcome + ", a report before it said done: look at it";
  if (is_over(*item) && item->kind == "panel" && !item->seen && actual.revision == 0)
    if (const std::string doubt = release_doubt(*item, actual); !doubt.empty()) return doubt;
  if (item->revision == 0)
    return std::string("the item is ") + name_of(item->status) + ", not RELEASED: nobody asked for it; measure it";
  if (actual.revision != 0 && actual.revision != item->revision)
    return "is of revision " + std::to_string(actual.revision) + ", the item was released with " +
           std::to_string(item->revision) + ": a job that is no longer valid was executed; measure the item";
  if (item->status != ItemStatus::released && item->status != ItemStatus::executing)
    return std::string("the item is ") + name_of(item->status) + ", not RELEASED: nobody asked for it; measure it";
  if (const std::string doubt = release_doubt(*item, actual); !doubt.empty()) return doubt;
  if (const std::string doubt = date_doubt(*item, actual); !doubt.empty()) return doubt;
  if (const std::string doubt = setting_doubt(*item, actual); !doubt.empty()) return doubt;
  if (actual.measured.allFinite() && item->expected.allFinite())
    return place_doubt(actual.measured, item->expected, kReach);
  return {};
}

/// `named`: how many items have this name.
LoopItemT* item_of(const LoopStateT& state, const std::string& name, int& named) {
  LoopItemT* item = nullptr;
  for (const auto& candidate : state.items)
    if (candidate->id == name) item = candidate.get(), ++named;
  return item;
}

}  // namespace

std::vector<std::string> apply_actuals(LoopStateT& state, const ActualsT& actuals, std::vector<std::string>* doubted,
                                       const std::string& now) {
  std::vector<std::string> refused;
  const CopiedPlaces copied(state, actuals);
  RecalledOrders recalled(state);
  const auto may_count = [&](const ActualT& actual) {
    int named = 0;
    const LoopItemT* item = item_of(state, actual.item, named);
    if (named != 1) return false;
    // What is reported as done in this round as well may be taken down in it.
    return objection(item, actual, now).empty() || (is_removal(actual) && is_of_release(*item, actual));
  };
  for (const auto& [actual, replaced] : in_order_of_time(actuals, may_count)) {
    const std::string report = words_of(*actual);
    if (!replaced.empty()) {
      refused.push_back(report + replaced);
      continue;
    }
    int named = 0;
    LoopItemT* item = item_of(state, actual->item, named);
    if (named == 1 && says_sill_was_knocked(*item, *actual, now)) {
      take_knock(state, *item, *actual, now);
      continue;
    }
    if (named == 1 && shows_what_was_reported(*item, *actual, copied, now)) {
      item->seen = true, item->place = place_of_report(*actual);
      note(state, *item, by_report(*actual, "measured where it hangs", now));
      continue;
    }
    if (named == 1 && contradicts(*item, *actual)) {
      take_contradiction(state, *item, *actual, now);
      if (doubted)
        doubted->push_back(report + "says " + actual->outcome +
                           ", a report before it said done: look whether it hangs");
      continue;
    }
    const std::string why_not = named > 1   ? "a bracket and a panel have this name: give one of them another"
                                : named < 1 ? unknown_words(state, actual->item)
                                            : objection(item, *actual, now);
    if (!why_not.empty()) {
      if (named == 1 && future_doubt(*actual, now).empty()) recalled.take(*item, *actual, by_report(*actual, "", now));
      refused.push_back(report + why_not);
      continue;
    }
    const Because because =
        by_report(*actual, actual->note.empty() ? "reported " + actual->outcome : actual->note, now);
    if (is_removal(*actual)) {
      unhang(state, *item, by_report(*actual, "reported removed" + note_of(*actual), now));
    } else if (actual->outcome == "done") {
      take_done(state, *item, *actual, copied, because);
      if (const std::string doubt = no_proof(*item, *actual, copied); doubted && !doubt.empty())
        doubted->push_back(report + doubt);
    } else {
      move(state, *item, ItemStatus::planned, by_report(*actual, actual->outcome + ": " + because.why, now));
      item->pending.setZero();
      // Somebody who failed may have moved it: the next measurement says where it is.
      if (actual->outcome == "failed") item->expected.setConstant(kUnknown);
    }
  }
  return refused;
}

void note_refused(LoopStateT& state, const std::vector<std::string>& refused) {
  for (const std::string& words : refused) {
    // "reports.json: items[4]: why": the place in the file belongs to the report.
    const auto items = words.find(": items[");
    const auto colon = words.find(": ", items == std::string::npos ? 0 : items + 2);
    auto out = std::make_unique<RefusedReportT>();
    out->round = state.round + 1;
    out->report = words.substr(0, colon);
    out->why = colon == std::string::npos ? std::string() : words.substr(colon + 2);
    state.refused.push_back(std::move(out));
  }
}

}  // namespace plumbline::loop
