// How often is a verdict wrong, and how often is a shift told that is none? Buildings and measurements of them are
// drawn without a survey or photographs, judged by the library, and held against the same judgement of the truth.
//
//   judgement_benchmark false_passes [CAMPAIGNS [FIRST_SEED]]
//   judgement_benchmark shifts [BUILDINGS [FIRST_SEED]]
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "building/judgement/deviation.hpp"
#include "geometry/random.hpp"
#include "geometry/statistics.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::judgement;
using Eigen::Index;
using Eigen::Vector3d;

constexpr double kTau = 5e-3;

struct Size {
  int facades, floors, columns;
};

/// Facades around a court or a block, each with its own direction; anchors 2 m apart, storeys of 3 m, a panel between
/// every four anchors.
DeviationInputs building(const Size& size, const ToleranceTable& table) {
  DeviationInputs inputs;
  inputs.design_file = "drawn.ifc";
  const int columns = size.columns, all = size.facades * columns;
  for (int floor = 0; floor < size.floors; ++floor)
    for (int column = 0; column < all; ++column) {
      const int side = column / columns;
      const double turn = 2 * std::numbers::pi * side / std::max(2, size.facades);
      const Vector3d out = ifc::facing(turn), right = Vector3d::UnitZ().cross(out);
      AnchorCase anchor;
      anchor.id = "F" + std::to_string(floor + 1) + "-C" + std::to_string(column + 1);
      anchor.element.guid = "g" + anchor.id, anchor.element.name = anchor.id;
      anchor.floor = floor + 1, anchor.column = column + 1, anchor.use = "check";
      anchor.element.batch = "batch-" + std::to_string((floor * all + column) % 3);
      anchor.design = 10 * out + right * (2.0 * (column % columns)) + Vector3d(0, 0, 3.0 * floor);
      anchor.facade = ifc::frame_facing(out, ifc::FacadeSource::rule, true);
      anchor.tolerances = tolerances_of(table, anchor.element);
      inputs.model.ids.push_back(anchor.id), inputs.model.positions.push_back(anchor.design);
      inputs.anchors.push_back(std::move(anchor));
    }
  for (int floor = 0; floor + 1 < size.floors; ++floor)
    for (int column = 0; column + 1 < all; ++column) {
      if (column % columns == columns - 1) continue;
      PanelCase panel;
      const auto corner = static_cast<std::size_t>(floor * all + column),
                 above = corner + static_cast<std::size_t>(all);
      const ifc::FacadeFrame& frame = inputs.anchors[corner].facade;
      panel.guid = panel.name = "P" + inputs.anchors[corner].id, panel.facade = frame;
      Eigen::Matrix3d axes;
      axes << frame.right, -frame.out, frame.up;
      panel.frame_from_panel = {Eigen::Quaterniond(axes), inputs.anchors[corner].design};
      panel.low = {0.01, -0.03, 0.01}, panel.high = {1.99, 0.01, 2.985};
      panel.tolerances = tolerances_of(table, {});
      panel.anchors = {corner, corner + 1, above, above + 1};
      inputs.panels.push_back(std::move(panel));
    }
  std::vector<ifc::Facing> all_faces;
  for (auto& anchor : inputs.anchors) all_faces.push_back({anchor.design, &anchor.facade, false});
  for (auto& panel : inputs.panels) all_faces.push_back({panel.frame_from_panel.translation, &panel.facade, true});
  inputs.facades = ifc::group_facades(all_faces);
  return inputs;
}

/// Of a measurement: each anchor by itself, and heights of a floor together (its set-up).
Eigen::MatrixXd covariance_of(const DeviationInputs& inputs, double own, double common) {
  const auto n = static_cast<Index>(inputs.anchors.size());
  Eigen::MatrixXd s = own * own * Eigen::MatrixXd::Identity(3 * n, 3 * n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j)
      if (inputs.anchors[i].floor == inputs.anchors[j].floor) s(3 * i + 2, 3 * j + 2) += common * common;
  return s;
}

/// Wrong passes among what is truly out, and among what passes.
struct Count {
  int cases = 0, out = 0, passed = 0, wrong = 0, undecided = 0, failed = 0, wrong_fail = 0;
  double promised = 0;  ///< sum of 1 - P over what passes: as many are expected to be wrong
  void add(ToleranceVerdict verdict, ToleranceVerdict truth, double probability) {
    const bool truly_out = truth == ToleranceVerdict::fail;
    ++cases, out += truly_out;
    undecided += verdict == ToleranceVerdict::undecided;
    failed += verdict == ToleranceVerdict::fail, wrong_fail += verdict == ToleranceVerdict::fail && !truly_out;
    if (verdict != ToleranceVerdict::pass) return;
    ++passed, wrong += truly_out;
    if (std::isfinite(probability)) promised += 1 - probability;
  }
};

struct Counts {
  Count anchors, panels, floors;
};

struct Tolerated {
  const char* name;
  std::vector<std::string> rules;
};

const std::vector<Tolerated>& tolerated() {
  static const std::vector<Tolerated> all = {
      {"horizontal 5, vertical 5 (default)", {}},
      {"vertical 5", {"*: horizontal=0mm"}},
      {"vertical +5/-2", {"*: horizontal=0mm, vertical=+5/-2mm"}},
      {"out of plane 5", {"*: horizontal=0mm, vertical=0mm, out_of_plane=5mm"}},
      {"space 5", {"*: horizontal=0mm, vertical=0mm, space=5mm"}},
      {"in plane 5, out of plane 5", {"*: horizontal=0mm, vertical=0mm, in_plane=5mm, out_of_plane=5mm"}},
      {"all five axes 5", {"*: in_plane=5mm, out_of_plane=5mm, space=5mm"}},
      {"vertical +5/-2, out of plane +2/-5", {"*: horizontal=0mm, vertical=+5/-2mm, out_of_plane=+2/-5mm"}},
      {"out of plane +5/-0", {"*: horizontal=0mm, vertical=0mm, out_of_plane=+5/-0mm"}},
  };
  return all;
}

Counts one_campaign(const DeviationInputs& design, const Eigen::MatrixXd& covariance, double u, double built,
                    std::uint64_t seed) {
  DeviationInputs truth = design, measured = design;
  const std::size_t n = design.anchors.size();
  std::vector<double> of_floor;
  for (int floor = 0; floor < 100; ++floor)
    of_floor.push_back(Random(seed, "set-up", static_cast<std::uint64_t>(floor)).normal(0.5 * u));
  for (std::size_t i = 0; i < n; ++i) {
    Random random(seed, "anchor", i);
    truth.model.positions[i] += random.normal3(built);
    measured.model.positions[i] = truth.model.positions[i] + random.normal3(std::sqrt(0.75) * u) +
                                  Vector3d(0, 0, of_floor[design.anchors[i].floor]);
  }
  const auto size = static_cast<Index>(3 * n);
  truth.model.covariance = 1e-18 * Eigen::MatrixXd::Identity(size, size);
  measured.model.covariance = covariance;
  const DeviationT right = judge_deviations(truth, {}), told = judge_deviations(measured, {});
  Counts counts;
  for (std::size_t i = 0; i < n; ++i)
    counts.anchors.add(told.anchors[i]->verdict, right.anchors[i]->verdict, told.anchors[i]->pass_probability);
  for (std::size_t i = 0; i < told.panels.size(); ++i)
    counts.panels.add(told.panels[i]->verdict, right.panels[i]->verdict, told.panels[i]->pass_probability);
  for (std::size_t i = 0; i < told.floors.size(); ++i)
    counts.floors.add(told.floors[i]->verdict, right.floors[i]->verdict, std::nan(""));
  return counts;
}

/// A share of campaigns' cases with the half width of its 95 % interval, by the scatter between campaigns.
std::string share(const std::vector<Counts>& all, Count Counts::*level, int Count::*cases, int Count::*hits) {
  double n = 0, h = 0, scatter = 0;
  for (const Counts& c : all) n += (c.*level).*cases, h += (c.*level).*hits;
  if (n == 0) return "none";
  for (const Counts& c : all) {
    const double rest = (c.*level).*hits - h / n * ((c.*level).*cases);
    scatter += rest * rest;
  }
  char text[80];
  std::snprintf(text, sizeof text, "%.2f ± %.2f %% of %.0f", 100 * h / n, 196 * std::sqrt(scatter) / n, n);
  return text;
}

void false_passes(int campaigns, std::uint64_t first) {
  std::puts(
      "| tolerances [mm] | u / tolerance | of | truly out that pass | passes that are truly out | expected of them by "
      "their probabilities | undecided | fails that are truly in |\n|---|---|---|---|---|---|---|---|");
  for (const Tolerated& asked : tolerated()) {
    ToleranceTable table{kTau, false, {}};
    for (const std::string& rule : asked.rules) table.rules.push_back(parse_rule(rule));
    const DeviationInputs design = building({4, 2, 3}, table);
    for (const double ratio : {0.1, 0.2, 0.3, 0.4, 0.5}) {
      const double u = ratio * kTau;
      const Eigen::MatrixXd covariance = covariance_of(design, std::sqrt(0.75) * u, 0.5 * u);
      std::vector<Counts> all(static_cast<std::size_t>(campaigns));
      tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t k) {
        const double built = (k % 3 == 0 ? 0.2 : k % 3 == 1 ? 0.4 : 0.8) * kTau;
        all[k] = one_campaign(design, covariance, u, built, first + k);
      });
      for (const auto& [name, level] :
           {std::pair{"anchors", &Counts::anchors}, {"panels", &Counts::panels}, {"floors", &Counts::floors}}) {
        double promised = 0, passed = 0;
        for (const Counts& c : all) promised += (c.*level).promised, passed += (c.*level).passed;
        char expected[40] = "–";
        if (level != &Counts::floors && passed > 0)
          std::snprintf(expected, sizeof expected, "%.2f %%", 100 * promised / passed);
        std::printf("| %s | %.1f | %s | %s | %s | %s | %s | %s |\n", asked.name, ratio, name,
                    share(all, level, &Count::out, &Count::wrong).c_str(),
                    share(all, level, &Count::passed, &Count::wrong).c_str(), expected,
                    share(all, level, &Count::cases, &Count::undecided).c_str(),
                    share(all, level, &Count::failed, &Count::wrong_fail).c_str());
      }
      std::fflush(stdout);
    }
  }
}

/// How a building came to be: its anchors' deviations.
struct Built {
  const char* name;
  std::function<void(const DeviationInputs&, Random&, std::vector<Vector3d>&)> deviate;
};

std::vector<Built> sound() {
  const auto each = [](const auto& draw) {
    return [draw](const DeviationInputs& in, Random& random, std::vector<Vector3d>& d) {
      for (std::size_t i = 0; i < d.size(); ++i) d[i] = draw(in.anchors[i].facade, random);
    };
  };
  return {
      {"1.5 mm each axis", each([](const auto&, Random& r) -> Vector3d { return r.normal3(1.5e-3); })},
      {"3 mm each axis", each([](const auto&, Random& r) -> Vector3d { return r.normal3(3e-3); })},
      {"6 mm each axis", each([](const auto&, Random& r) -> Vector3d { return r.normal3(6e-3); })},
      {"8 mm out of plane, 1 mm else",
       each([](const ifc::FacadeFrame& f, Random& r) -> Vector3d { return r.normal3(1e-3) + r.normal(8e-3) * f.out; })},
      {"6 mm in height, 1 mm else", each([](const ifc::FacadeFrame&, Random& r) -> Vector3d {
         return r.normal3(1e-3) + Vector3d(0, 0, r.normal(6e-3));
       })},
      {"2 mm, one in five 12 mm", each([](const ifc::FacadeFrame&, Random& r) -> Vector3d {
         return r.normal3(r.uniform() < 0.2 ? 12e-3 : 2e-3);
       })},
      {"2 mm; every floor with a scatter of its own, 1 to 8 mm",
       [](const DeviationInputs& in, Random& r, std::vector<Vector3d>& d) {
         std::vector<double> scatter;
         for (int floor = 0; floor < 100; ++floor) scatter.push_back(r.uniform(1e-3, 8e-3));
         for (std::size_t i = 0; i < d.size(); ++i) d[i] = r.normal3(scatter[in.anchors[i].floor]);
       }},
  };
}

struct Planted {
  const char* name;
  const char* kind;
  std::string told;  ///< the group's name
  std::function<Vector3d(const AnchorCase&)> shift;
};

std::vector<Planted> shifts() {
  const auto where = [](bool there, const Vector3d& shift) -> Vector3d { return there ? shift : Vector3d(0, 0, 0); };
  const auto up = [](double z) { return Vector3d(0, 0, z); };
  return {
      {"floor 2 12 mm low", "floor", "Floor 2", [=](const AnchorCase& a) { return where(a.floor == 2, up(-12e-3)); }},
      {"floor 2 5 mm low", "floor", "Floor 2", [=](const AnchorCase& a) { return where(a.floor == 2, up(-5e-3)); }},
      {"floors 2 and 4, 12 mm low and 8 mm high", "floor", "Floor 2",
       [=](const AnchorCase& a) { return where(a.floor == 2 || a.floor == 4, up(a.floor == 2 ? -12e-3 : 8e-3)); }},
      {"a facade 8 mm too far out", "facade", "Facade ",
       [=](const AnchorCase& a) { return where(a.column <= 4, 8e-3 * a.facade.out); }},
      {"floor 3 of a facade 10 mm too far out", "floor of a facade", "Floor 3 of facade",
       [=](const AnchorCase& a) { return where(a.column <= 4 && a.floor == 3, 10e-3 * a.facade.out); }},
      {"column 3 9 mm to the right", "column", "Column 3",
       [=](const AnchorCase& a) { return where(a.column == 3, 9e-3 * a.facade.right); }},
      {"a print batch 7 mm high", "batch", "Print batch batch-1",
       [=](const AnchorCase& a) { return where(a.element.batch == "batch-1", up(7e-3)); }},
      {"the building 9 mm to the east", "common", "",
       [](const AnchorCase&) -> Vector3d {
         return {9e-3, 0, 0};
       }},
  };
}

DeviationT judged(const DeviationInputs& design, const Eigen::MatrixXd& covariance, const Built& built,
                  const Planted* planted, std::uint64_t seed) {
  DeviationInputs inputs = design;
  Random random(seed, built.name);
  std::vector<Vector3d> deviations(design.anchors.size());
  built.deviate(design, random, deviations);
  for (std::size_t i = 0; i < deviations.size(); ++i) {
    inputs.model.positions[i] += deviations[i] + Random(seed, "measured", i).normal3(0.5e-3);
    if (planted) inputs.model.positions[i] += planted->shift(design.anchors[i]);
  }
  inputs.model.covariance = covariance;
  return judge_deviations(inputs, {});
}

void shift_rates(int buildings, std::uint64_t first) {
  const ToleranceTable table{kTau, false, {}};
  std::puts("| sound buildings | size | with a common shift told | with a group shift told |\n|---|---|---|---|");
  for (const Size size : {Size{1, 5, 4}, Size{4, 6, 4}, Size{1, 4, 12}}) {
    DeviationInputs design = building(size, table);
    design.panels.clear();
    const Eigen::MatrixXd covariance = covariance_of(design, 0.5e-3, 0);
    for (const Built& built : sound()) {
      std::vector<std::array<int, 2>> alarms(static_cast<std::size_t>(buildings));
      tbb::parallel_for(std::size_t{0}, alarms.size(), [&](std::size_t k) {
        const DeviationT result = judged(design, covariance, built, nullptr, first + k);
        bool any = false;
        for (const auto& group : result.group_shifts) any = any || group->significant;
        alarms[k] = {result.common_shift && result.common_shift->significant, any};
      });
      int common = 0, group = 0;
      for (const auto& a : alarms) common += a[0], group += a[1];
      const Interval c = clopper_pearson_interval(common, buildings, 0.95),
                     g = clopper_pearson_interval(group, buildings, 0.95);
      std::printf("| %s | %d × %d × %d | %d of %d (%.2f–%.2f %%) | %d of %d (%.2f–%.2f %%) |\n", built.name,
                  size.facades, size.floors, size.columns, common, buildings, 100 * c.lower, 100 * c.upper, group,
                  buildings, 100 * g.lower, 100 * g.upper);
      std::fflush(stdout);
    }
  }
  std::puts(
      "\n| planted, 4 facades × 6 floors × 4 columns | scatter | told, by its name | and nothing else "
      "|\n|---|---|---|---|");
  DeviationInputs design = building({4, 6, 4}, table);
  design.panels.clear();
  const Eigen::MatrixXd covariance = covariance_of(design, 0.5e-3, 0);
  for (const Planted& planted : shifts())
    for (const Built& built : {sound()[0], sound()[1], sound()[5]}) {
      std::vector<std::array<int, 2>> found(static_cast<std::size_t>(buildings));
      tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t k) {
        const DeviationT result = judged(design, covariance, built, &planted, first + k);
        int named = 0, others = 0;
        for (const auto& group : result.group_shifts)
          if (group->significant)
            ++(group->kind == planted.kind && group->name.starts_with(planted.told) ? named : others);
        if (planted.kind == std::string("common"))
          named = result.common_shift && result.common_shift->significant;
        else
          others += result.common_shift && result.common_shift->significant;
        if (std::string(planted.name).starts_with("floors")) others -= others > 0;
        found[k] = {named > 0, named > 0 && others == 0};
      });
      int told = 0, alone = 0;
      for (const auto& f : found) told += f[0], alone += f[1];
      std::printf("| %s | %s | %.1f %% | %.1f %% |\n", planted.name, built.name, 100.0 * told / buildings,
                  100.0 * alone / buildings);
      std::fflush(stdout);
    }
}

}  // namespace

int main(int count, char** words) {
  const std::string what = count > 1 ? words[1] : "";
  const int campaigns = count > 2 ? std::atoi(words[2]) : 1000;
  const auto first = static_cast<std::uint64_t>(count > 3 ? std::atoll(words[3]) : 1);
  if (what == "false_passes" && campaigns > 0)
    false_passes(campaigns, first);
  else if (what == "shifts" && campaigns > 0)
    shift_rates(campaigns, first);
  else
    return std::fputs("usage: judgement_benchmark false_passes|shifts [NUMBER [FIRST_SEED]]\n", stderr), 2;
}
