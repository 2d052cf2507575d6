#include "loop/state/report_order.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "base/text/words.hpp"
#include "loop/state/date.hpp"

namespace plumbline::loop {
namespace {

/// Places, or settings, that differ by less say the same [m].
constexpr double kSaysTheSame = 0.001;

std::string read_at(const ActualT& report) { return report.source.empty() ? "" : " (" + report.source + ")"; }

double difference_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return a.allFinite() && b.allFinite() ? (a - b).cwiseAbs().maxCoeff() : 0;
}

bool says_the_same(const ActualT& a, const ActualT& b) {
  return a.outcome == b.outcome && difference_of(a.measured, b.measured) <= kSaysTheSame &&
         difference_of(a.setting, b.setting) <= kSaysTheSame;
}

/// "failed", or where it says something else: "done 28.0 mm elsewhere".
std::string what_it_says(const ActualT& report, const ActualT& other) {
  if (report.outcome != other.outcome) return report.outcome;
  return report.outcome + " " +
         text::millimetres(
             std::max(difference_of(report.measured, other.measured), difference_of(report.setting, other.setting))) +
         " elsewhere";
}

class ReportsOfItem {
 public:
  ReportsOfItem(const ActualsT& actuals, std::vector<OrderedReport*> of_item)
      : actuals_(actuals), of_item_(std::move(of_item)) {}

  void compare() {
    sort();
    for (std::size_t i = 0; i < of_item_.size(); ++i)
      for (std::size_t j = i + 1; j < of_item_.size(); ++j)
        if (!says_the_same(*of_item_[i]->report, *of_item_[j]->report)) contradict(*of_item_[i], *of_item_[j]);
    // What is contradicted in its own time replaces nothing, but nothing older is more certain than it.
    for (std::size_t i = 0; i < of_item_.size(); ++i)
      for (std::size_t j = of_item_.size() - 1; j > i && of_item_[i]->why_not.empty(); --j)
        replace(*of_item_[i], *of_item_[j]);
  }

 private:
  static std::optional<double> time_of(const OrderedReport& ordered) { return seconds_of(ordered.report->at); }

  void sort() {
    if (!std::all_of(of_item_.begin(), of_item_.end(), [](const auto* one) { return time_of(*one).has_value(); }))
      return;
    std::vector<OrderedReport> sorted;
    for (const OrderedReport* one : of_item_) sorted.push_back(*one);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const auto& a, const auto& b) { return *time_of(a) < *time_of(b); });
    for (std::size_t i = 0; i < sorted.size(); ++i) *of_item_[i] = sorted[i];
  }

  void contradict(OrderedReport& a, OrderedReport& b) const {
    const std::optional<double> of_a = time_of(a), of_b = time_of(b);
    if (of_a && of_b ? *of_a != *of_b : report_file(*a.report, actuals_) == report_file(*b.report, actuals_)) return;
    const auto words = [&](const ActualT& one, const ActualT& other) {
      const std::string begin = "says " + what_it_says(one, other) + ", and another one";
      return (of_a && of_b
                  ? begin + " of the same time, " + other.at + read_at(other) + ", says " + what_it_says(other, one)
                  : begin + read_at(other) + " says " + what_it_says(other, one) + ", and not both have a date") +
             ": none of them is taken; look at it and report it once";
    };
    if (a.why_not.empty()) a.why_not = words(*a.report, *b.report);
    if (b.why_not.empty()) b.why_not = words(*b.report, *a.report);
  }

  /// What a later report that says done says otherwise is over. Of done and then failed the state machine knows what to
  /// do.
  static void replace(OrderedReport& earlier, const OrderedReport& other) {
    const ActualT &report = *earlier.report, &counts = *other.report;
    const std::optional<double> then = time_of(earlier), later = time_of(other);
    if (!then || !later || *then >= *later) return;
    if (!other.why_not.empty() || (counts.outcome == "done" && !says_the_same(report, counts)))
      earlier.why_not = "is of " + report.at + ", and a later one " + (other.why_not.empty() ? "counts: " : "says ") +
                        counts.outcome + " at " + counts.at + read_at(counts);
  }

  const ActualsT& actuals_;
  std::vector<OrderedReport*> of_item_;
};

}  // namespace

std::string report_file(const ActualT& report, const ActualsT& actuals) {
  std::string file;
  for (const std::string& source : actuals.sources)
    if (report.source.starts_with(source) && source.size() > file.size()) file = source;
  return file;
}

std::vector<OrderedReport> in_order_of_time(const ActualsT& actuals,
                                            const std::function<bool(const ActualT&)>& may_count) {
  std::vector<OrderedReport> ordered;
  for (const auto& report : actuals.items) ordered.push_back({report.get(), {}});
  std::map<std::string, std::vector<OrderedReport*>> by_item;
  for (OrderedReport& one : ordered)
    if (may_count(*one.report)) by_item[one.report->item].push_back(&one);
  for (auto& [item, of_item] : by_item)
    if (of_item.size() > 1) ReportsOfItem(actuals, std::move(of_item)).compare();
  return ordered;
}

}  // namespace plumbline::loop
