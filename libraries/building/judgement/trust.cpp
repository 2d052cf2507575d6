#include "building/judgement/trust.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "base/text/words.hpp"

namespace plumbline::judgement {
namespace {

std::string text_of(const flatbuffers::String* text) { return text ? text->str() : std::string(); }

/// `about`: which test says it, of what, without figures: by that another campaign knows the finding again.
MeasurementDoubtT finding(MeasurementPart part, DoubtGrade grade, std::string about, std::string reason) {
  MeasurementDoubtT found;
  found.part = part, found.grade = grade, found.about = std::move(about), found.reason = std::move(reason);
  return found;
}

/// Of what the camera model leaves out: the command, with the size that the test itself found. A standard deviation
/// that is too small for it would make the images contradict it, and nothing would be trusted any more.
void say_what_mends(const BlockTest& test, MeasurementDoubtT& misfit) {
  if (test.kind() == BlockTestKind::principal_points) {
    constexpr double kUsual = 0.5, kLeast = 0.1;  // [px] of a lens that is focused between images; what can be told
    const double shift = test.shift();
    misfit.mend = fmt::format("block.with.image_principal_point_sigma={:.1f}",
                              std::isfinite(shift) ? std::max(shift, kLeast) : kUsual);
    misfit.mend_note = std::isfinite(shift) ? "px; as large as the images show it"
                                            : "px; 0.1 to 1 for lenses that are focused or stabilised between images";
  } else if (test.kind() == BlockTestKind::distances) {
    misfit.mend = "block.with.free_interior=[fx, fy, cx, cy, k1, k2, k3, k4, p1, p2, d1, d2]";
  }
}

void take_misfit(MeasurementDoubtT misfit, double variance_factor, Trust& trust) {
  trust.factor = std::max(trust.factor, variance_factor);
  misfit.factor = std::sqrt(variance_factor);
  trust.misfits.push_back(std::move(misfit));
}

std::string words_of(const NetworkKnownPoint& k) {
  std::string text = text_of(k.id());
  const char* separator = "";
  const Vec3 &difference = *k.difference(), &sigma = *k.sigma();
  const std::array<std::tuple<char, double, double>, 3> axes = {
      {{'E', difference.x(), sigma.x()}, {'N', difference.y(), sigma.y()}, {'H', difference.z(), sigma.z()}}};
  for (const auto& [axis, d, s] : axes)
    if (!std::isnan(s)) text += fmt::format("{} {} {:+.1f}", std::exchange(separator, ","), axis, 1e3 * d);
  return text + " mm";
}

/// As an item of a list that is typed: one with a comma, or what ends a list or begins a remark, is quoted.
std::string list_item(const std::string& text) {
  if (text.find_first_of(",'\"[]{}#") == std::string::npos) return text;
  const char quote = text.find('\'') == std::string::npos ? '\'' : '"';
  return quote + text + quote;
}

/// The whole of the parameter `exclude` with items more: what is typed stands in the place of what was there.
std::string exclude_also(const SurveyNetwork& network, const std::vector<std::string>& items) {
  std::vector<std::string> all;
  if (network.exclusions())
    for (const auto* before : *network.exclusions()) all.push_back(list_item(text_of(before)));
  for (const std::string& item : items) all.push_back(list_item(item));
  return "network.with.exclude=[" + text::join(all) + "]";
}

std::optional<MeasurementDoubtT> doubt_of_control_as_a_whole(const SurveyNetwork& network) {
  if (!network.findings()) return std::nullopt;
  for (const auto* f : *network.findings())
    if (text_of(f->subject()) == "control")
      return finding(MeasurementPart::survey, DoubtGrade::doubt, "control", text_of(f->text()));
  return std::nullopt;
}

using KnownPoints = std::vector<const NetworkKnownPoint*>;

bool is_contradicted(const NetworkKnownPoint& k) { return k.rank() > 0 && k.statistic() > k.critical(); }

/// Those that are contradicted, the clearest first.
KnownPoints contradicted(const flatbuffers::Vector<flatbuffers::Offset<NetworkKnownPoint>>* points) {
  KnownPoints wrong;
  for (unsigned i = 0; points && i < points->size(); ++i)
    if (is_contradicted(*points->Get(i))) wrong.push_back(points->Get(i));
  std::stable_sort(wrong.begin(), wrong.end(),
                   [](const auto* a, const auto* b) { return a->statistic() > b->statistic(); });
  return wrong;
}

/// Whether what it contradicts is its height more than its plan.
bool is_of_height(const NetworkKnownPoint& k) {
  const Vec3& d = *k.difference();
  return std::abs(d.z()) > std::hypot(d.x(), d.y());
}

bool is_known_in(const NetworkKnownPoint& k, bool height) {
  return !std::isnan(height ? k.sigma()->z() : k.sigma()->x());
}

/// Known points that hold the survey in height, or in plan.
std::size_t holding(const SurveyNetwork& network, bool height) {
  std::size_t n = 0;
  const unsigned known = network.known_points() ? network.known_points()->size() : 0;
  for (unsigned i = 0; i < known; ++i) n += is_known_in(*network.known_points()->Get(i), height);
  return known > 0 || !network.datum_points() ? n : network.datum_points()->size();
}

/// Of those that were left out, the ones that speak against the result where `one` does.
std::vector<std::string> left_out_alike(const SurveyNetwork& network, const NetworkKnownPoint& one) {
  std::vector<std::string> ids;
  for (const auto* k : contradicted(network.left_out_known()))
    if (is_of_height(*k) == is_of_height(one)) ids.push_back(text_of(k->id()));
  return ids;
}

constexpr const char* kFindOut =
    "measure a further known point, or find out which of them are wrong: these are left out with network.with.exclude, "
    "and no longer speak against it once they are out of the control file";

/// What was left out by somebody's word is no proof of it: known points that contradict the result are as good as those
/// that hold it, and where they are as many nothing but that word decides which of them are right.
std::optional<MeasurementDoubtT> doubt_of_what_was_left_out(const SurveyNetwork& network) {
  const KnownPoints against = contradicted(network.left_out_known());
  for (const NetworkKnownPoint* worst : against) {
    const std::vector<std::string> alike = left_out_alike(network, *worst);
    if (alike.size() < holding(network, is_of_height(*worst))) continue;
    MeasurementDoubtT doubt =
        finding(MeasurementPart::survey, DoubtGrade::doubt, "known_points_left_out",
                "known points that were left out contradict it, and are as many as those that hold it: " +
                    text::join(alike, 4) + "; as measured minus as known: " + words_of(*worst));
    doubt.mend_note = kFindOut;
    return doubt;
  }
  return std::nullopt;
}

/// A known point that the survey contradicts bends it, and nothing says by how much: the estimate of the difference is
/// no standard deviation, and which of two points is the wrong one is often not to be told. So nothing is decided until
/// it is mended, left out, or the standard deviations of the control say that it may differ by so much. A command is
/// given only where the test tells which one it is, and most of the others stay to say so.
std::optional<MeasurementDoubtT> doubt_of_control(const SurveyNetwork& network) {
  const KnownPoints wrong = contradicted(network.known_points());
  if (wrong.empty()) {
    auto doubt = doubt_of_control_as_a_whole(network);
    return doubt ? std::move(doubt) : doubt_of_what_was_left_out(network);
  }
  constexpr double kNoWorse = 6.6;  // of the statistic, 99 %: the test does not tell which of the two it is
  std::vector<std::string> others, less;
  for (std::size_t i = 1; i < wrong.size(); ++i)
    (wrong.front()->statistic() - wrong[i]->statistic() < kNoWorse ? others : less).push_back(text_of(wrong[i]->id()));
  const std::string worst = text_of(wrong.front()->id());
  const std::vector<std::string> out = left_out_alike(network, *wrong.front());
  MeasurementDoubtT doubt = finding(
      MeasurementPart::survey, DoubtGrade::doubt, "known_points",
      "known points contradict it and each other, as measured minus as known: " + words_of(*wrong.front()) +
          (others.empty() ? ""
                          : "; as much, and the test does not tell which of them is wrong: " + text::join(others, 4)) +
          (less.empty() ? "" : "; less so, and perhaps because of it: " + text::join(less, 4)) +
          (out.empty() ? "" : "; and so do those that were left out: " + text::join(out, 4)));
  if (!others.empty() || out.size() + 2 >= holding(network, is_of_height(*wrong.front()))) {
    doubt.mend_note = kFindOut;
    return doubt;
  }
  doubt.mend = exclude_also(network, {"control " + worst + ": contradicts the survey"});
  doubt.mend_note =
      "if it has moved or its coordinates are wrong; else mend these or their standard deviations in the "
      "control file";
  return doubt;
}

/// Points that others hang on: stations, known points.
std::set<std::string> held_points(const SurveyNetwork& network) {
  std::set<std::string> ids;
  for (unsigned i = 0; network.set_ups() && i < network.set_ups()->size(); ++i)
    ids.insert(text_of(network.set_ups()->Get(i)->station()));
  for (unsigned i = 0; network.known_points() && i < network.known_points()->size(); ++i)
    ids.insert(text_of(network.known_points()->Get(i)->id()));
  return ids;
}

/// Of two readings one is wrong, and which is chance: what hangs on them lies at one of two places. Without the points
/// the rest is as sure as it says; a station or a known point cannot be left out.
std::optional<MeasurementDoubtT> doubt_of_choices(const SurveyNetwork& network) {
  std::optional<MeasurementDoubtT> doubt;
  std::vector<std::string> points;
  std::size_t choices = 0;
  for (unsigned i = 0; network.findings() && i < network.findings()->size(); ++i) {
    const auto* f = network.findings()->Get(i);
    if (text_of(f->subject()) != "either") continue;
    if (choices++ == 0) doubt = finding(MeasurementPart::survey, DoubtGrade::doubt, "either", text_of(f->text()));
    for (unsigned k = 0; f->points() && k < f->points()->size(); ++k)
      if (const std::string id = text_of(f->points()->Get(k));
          std::find(points.begin(), points.end(), id) == points.end())
        points.push_back(id);
  }
  if (!doubt) return doubt;
  if (choices > 1) doubt->reason += fmt::format(" (and {} more of that kind)", choices - 1);
  const std::set<std::string> held = held_points(network);
  doubt->mend_note = "or measure once more what it names";
  if (std::any_of(points.begin(), points.end(), [&](const std::string& id) { return held.contains(id); })) {
    doubt->mend_note = "measure once more what it names";
    return doubt;
  }
  std::vector<std::string> items;
  for (const std::string& id : points) items.push_back("point " + id + ": one of its readings is wrong");
  doubt->mend = exclude_also(network, items);
  return doubt;
}

}  // namespace

Trust trust_of(const Block* block, const SurveyNetwork* network, Judged what) {
  Trust trust;
  if (network)
    if (auto doubt = doubt_of_control(*network)) trust.doubts.push_back(*std::move(doubt));
  if (network)
    if (auto doubt = doubt_of_choices(*network)) trust.doubts.push_back(*std::move(doubt));
  if (network && text_of(network->validity()) != "" && text_of(network->validity()) != "sound") {
    const auto* statistics = network->statistics();
    const bool tested =
        text_of(network->validity()) == "doubtful" && statistics && statistics->degrees_of_freedom() > 0;
    const std::string reason = text_of(network->verdict() ? network->verdict() : network->validity());
    const double factor =
        tested && !network->scaled_with_sigma0() ? std::max(std::pow(statistics->sigma0(), 2), 1.0) : 1;
    if (!tested || !std::isfinite(factor)) {
      trust.doubts.push_back(finding(MeasurementPart::survey, DoubtGrade::doubt, "network", reason));
      if (network->without_readings() && !tested) {
        trust.doubts.back().mend = "network.with.coordinates=tested";
        trust.doubts.back().mend_note = "if another program adjusted and tested them";
      }
    } else if (factor > 1 || trust.doubts.empty())  // known points that contradict it are doubted already
      take_misfit(finding(MeasurementPart::survey, DoubtGrade::misfit, "network", reason), factor, trust);
  }
  if (!block || !block->tests()) return trust;
  for (const auto* test : *block->tests()) {
    if (test->passed()) continue;
    const std::string reason = text_of(test->words() ? test->words() : test->group());
    const std::string about = EnumNameBlockTestKind(test->kind()) + ("/" + text_of(test->group()));
    // A group of observations that contradicts the rest proves the block wrong. What the camera model leaves out does
    // so where nobody knows by how much: no factor makes up for it.
    if (test->kind() == BlockTestKind::observations || !std::isfinite(test->variance_factor())) {
      trust.doubts.push_back(finding(MeasurementPart::image_block, DoubtGrade::doubt, about, reason));
      continue;
    }
    MeasurementDoubtT misfit = finding(MeasurementPart::image_block, DoubtGrade::misfit, about, reason);
    say_what_mends(*test, misfit);
    const bool is_in_them = what == Judged::points && std::isfinite(test->points_factor());
    take_misfit(std::move(misfit), is_in_them ? 1 : std::max(1.0, test->variance_factor()), trust);
  }
  return trust;
}

std::optional<FittedDatumT> fitted_datum(const Points& model, const Transform* design_from_survey) {
  FittedDatumT datum;
  if (const FittedDatum* of_points = model.fitted_to_design()) {
    of_points->UnPackTo(&datum);
    if (!std::isfinite(datum.datum_sigma) && design_from_survey) datum.datum_sigma = design_from_survey->datum_sigma();
    return datum;
  }
  if (!design_from_survey || !design_from_survey->fitted_to_design()) return std::nullopt;
  datum.origin = text_of(design_from_survey->origin());
  datum.datum_sigma = design_from_survey->datum_sigma();
  return datum;
}

std::optional<MeasurementDoubtT> doubt_of_datum(const FittedDatumT& datum) {
  if (std::isfinite(datum.datum_sigma)) return std::nullopt;
  MeasurementDoubtT doubt =
      finding(MeasurementPart::datum, DoubtGrade::doubt, "fitted_to_the_design",
              "the measurement was " + datum.origin +
                  "; these are to be judged, and a shift or turn of all of them together cannot be seen");
  doubt.mend_note = kSayHowTheWholeStands;
  return doubt;
}

std::string about_best_fit(const FittedDatumT& datum) {
  if (!std::isfinite(datum.datum_sigma)) return "";
  if (datum.datum_sigma == 0)
    return "Judged about the best fit of the anchors, as agreed (datum_sigma): where the whole stands is not judged.";
  return fmt::format(
      "Judged about the best fit of the anchors: that the whole stands as designed is taken as known to {:.1f} mm "
      "(datum_sigma), nothing here measures it.",
      1e3 * datum.datum_sigma);
}

}  // namespace plumbline::judgement
