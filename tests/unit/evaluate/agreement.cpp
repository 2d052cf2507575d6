#include "agreement.hpp"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>

#include "build/evaluate/design_input.hpp"
#include "build/evaluate/metrics.hpp"
#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/bcf.hpp"
#include "building/ifc/ifc_model.hpp"
#include "building/judgement/worst_first.hpp"
#include "show/report/report.hpp"
#include "show/report/summary.hpp"

namespace plumbline::judgement {
namespace {

using test::mm;

using Verdicts = std::map<std::string, std::string>;

/// Verdict by GlobalId out of the property sets of a name in an as-built IFC.
Verdicts verdicts_in_ifc(const step::File& file, const std::string& set_name) {
  const ifc::Model model(file);
  Verdicts found;
  for (const ifc::Entity& relation : model.all("IFCRELDEFINESBYPROPERTIES")) {
    const ifc::Entity set = model.entity(relation.reference("RelatingPropertyDefinition"));
    if (set.text("Name") != set_name) continue;
    for (const std::uint64_t id : set.references("HasProperties")) {
      const auto property = file.arguments(*file.find(id));
      if (property.at(0).text == "Verdict")
        found[file.arguments(*file.find(relation.references("RelatedObjects").at(0))).at(0).text] =
            property.at(2).items.at(0).items.at(0).text;
    }
  }
  return found;
}

/// As-built minus design by GlobalId out of an as-built IFC, m.
std::map<std::string, Eigen::Vector3d> deviations_in_ifc(const step::File& file, const std::string& set_name) {
  const ifc::Model model(file);
  std::map<std::string, Eigen::Vector3d> found;
  for (const ifc::Entity& relation : model.all("IFCRELDEFINESBYPROPERTIES")) {
    const ifc::Entity set = model.entity(relation.reference("RelatingPropertyDefinition"));
    if (set.text("Name") != set_name) continue;
    for (const std::uint64_t id : set.references("HasProperties")) {
      const auto property = file.arguments(*file.find(id));
      const std::string& name = property.at(0).text;
      if (name.size() == 10 && name.starts_with("Deviation") && name[9] >= 'X' && name[9] <= 'Z')
        found[file.arguments(*file.find(relation.references("RelatedObjects").at(0))).at(0).text][name[9] - 'X'] =
            property.at(2).items.at(0).number;
    }
  }
  return found;
}

/// The three corrections of a row, m.
Eigen::Vector3d corrections_in(const std::string& row) {
  std::vector<std::string> cells(1);
  for (const char c : row) {
    if (c == ';')
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return {std::stod(cells.at(4)), std::stod(cells.at(5)), std::stod(cells.at(6))};
}

/// Rows of the last table under an id in the page: name → verdict word of a column marked by an attribute.
Verdicts verdicts_in_page(const std::string& html, const std::string& attribute) {
  Verdicts found;
  const std::regex row("<tr[^>]*><th scope=\"row\">([^<]*)</th>(?:(?!</tr>)[\\s\\S])*?<td class=\"text\" " + attribute +
                       "=\"[0-9]*\"><span class=\"badge [a-z]+\">(?:(?!</span>)[\\s\\S])*?</svg>\\s*([a-z ]+)</span>");
  for (std::sregex_iterator it(html.begin(), html.end(), row), end; it != end; ++it) found[(*it)[1]] = (*it)[2];
  return found;
}

/// Floors of the page's overview: number (or "unknown") → verdict word and the counts behind it, separated by blanks.
Verdicts floors_in_page(const std::string& html) {
  Verdicts found;
  const std::size_t begin = html.find("Floor by floor</h3>");
  const std::string table = html.substr(begin, html.find("</table>", begin) - begin);
  const std::regex row(
      "<tr[^>]*><th scope=\"row\">([^<]*)</th>(?:(?!</tr>)[\\s\\S])*?</svg>\\s*([a-z "
      "]+)</span></td>((?:<td>[0-9]+</td>)+)");
  for (std::sregex_iterator it(table.begin(), table.end(), row), end; it != end; ++it)
    found[(*it)[1]] = (*it)[2].str() + std::regex_replace((*it)[3].str(), std::regex("<td>([0-9]+)</td>"), " $1");
  return found;
}

std::string word(ToleranceVerdict verdict) { return EnumNameToleranceVerdict(verdict); }
std::string spaced(ToleranceVerdict verdict) {
  return verdict == ToleranceVerdict::not_measured ? "not measured" : word(verdict);
}

}  // namespace

void expect_agreement(const Campaign& c, const std::string& epoch, std::array<int, 4>& seen) {
  const DeviationT& d = c.deviation;
  const step::File design(c.bytes, "f.ifc");
  ifc::AsBuiltIfcOptions options;
  options.epoch = epoch;
  const std::string bytes = ifc::enriched(design, ifc::write_as_built(design, c.design, d, c.accuracy, options));
  const step::File written(bytes, "a.ifc");
  const std::string suffix = epoch.empty() ? "" : "_" + epoch;
  const Verdicts anchors = verdicts_in_ifc(written, "ASB_AnchorDeviation" + suffix),
                 panels = verdicts_in_ifc(written, "ASB_PanelFit" + suffix),
                 floors = verdicts_in_ifc(written, "ASB_FloorStatistics" + suffix);
  const auto lengths = deviations_in_ifc(written, "ASB_AnchorDeviation" + suffix);
  ifc::BcfOptions bcf_options;
  bcf_options.project_guid = "0YvctVUKr0kugbFTf53O9L";
  const auto json = nlohmann::json::parse(metrics_json(c.accuracy, &d));
  const std::string csv = metrics_csv(c.accuracy, &d), junit = junit_xml(c.accuracy, &d),
                    bcf = ifc::write_bcf(d, judgement::worst_first(d), judgement::worst_panels_first(d), bcf_options);
  report::ReportInput input;
  input.accuracy.tau = c.accuracy.tau;
  for (const auto& a : c.accuracy.anchors) input.accuracy.anchors.push_back(std::make_unique<AnchorAccuracyT>(*a));
  input.deviation = d;
  const std::string html = report::render_report(input);
  const Verdicts page = verdicts_in_page(html, "data-anchor"), page_panels = verdicts_in_page(html, "data-panel");
  const Verdicts page_floors = floors_in_page(html);
  const std::string stake_out = "\n" + stake_out_csv(d);
  std::size_t open = 0;
  for (std::size_t i = 0; i < d.anchors.size(); ++i) {
    const AnchorDeviationT& a = *d.anchors[i];
    ++seen[static_cast<size_t>(a.verdict)];
    EXPECT_EQ(json["deviation"]["anchors"][i]["verdict"], word(a.verdict)) << a.id;
    if (!a.guid.empty()) {
      EXPECT_EQ(anchors.at(a.guid), ifc::label_of(a.verdict)) << a.id;
    }
    EXPECT_EQ(page.at(a.id), spaced(a.verdict)) << a.id;
    EXPECT_NE(csv.find("," + word(a.verdict) + "," + a.decided_by + ",", csv.find("\n" + a.id + ",")),
              std::string::npos)
        << a.id;
    if (a.design.allFinite()) {
      const std::size_t line = stake_out.find("\n" + a.id + ";");
      ASSERT_NE(line, std::string::npos) << a.id;
      const std::size_t line_end = stake_out.find('\n', line + 1);
      const std::string told = stake_out.substr(line, line_end - line) + (d.facades.size() > 1 ? "" : ";");
      EXPECT_NE(told.find(";" + word(a.verdict) + ";"), std::string::npos) << told;
      if (a.deviation.allFinite()) {
        EXPECT_LT((corrections_in(stake_out.substr(line + 1, line_end - line)) + a.deviation).norm(), 0.1 * mm) << a.id;
      }
    }
    if (a.deviation.allFinite()) {
      if (!a.guid.empty()) {
        EXPECT_LT((lengths.at(a.guid) - a.deviation).norm(), 2e-9) << a.id;
      }
      const auto& told = json["deviation"]["anchors"][i]["deviation"];
      EXPECT_LT((Eigen::Vector3d(told[0], told[1], told[2]) - a.deviation).norm(), 1e-9) << a.id;
    }
    const std::string test_case = "<testcase classname=\"anchors_against_design\" name=\"" + a.id + "\"";
    const std::size_t at = junit.find(test_case);
    ASSERT_NE(at, std::string::npos) << a.id;
    const std::string rest = junit.substr(at + test_case.size(), 60);
    EXPECT_EQ(rest.starts_with("/>"), a.verdict == ToleranceVerdict::pass) << a.id;
    EXPECT_EQ(rest.find("type=\"" + word(a.verdict)) != std::string::npos,
              a.verdict == ToleranceVerdict::fail || a.verdict == ToleranceVerdict::undecided)
        << a.id;
    const bool issue = a.verdict >= ToleranceVerdict::undecided;
    open += issue;
    EXPECT_EQ(bcf.find("<Selection><Component IfcGuid=\"" + a.guid + "\"") != std::string::npos, issue) << a.id;
  }
  std::size_t topic = 0;
  for (const AnchorDeviationT* a : judgement::worst_first(d)) {  // the issues in the order of the page
    if (a->verdict < ToleranceVerdict::undecided) continue;
    const std::size_t next = bcf.find("<Title>Anchor " + a->id + ":", topic);
    ASSERT_NE(next, std::string::npos) << a->id;
    topic = next;
  }
  for (std::size_t i = 0; i < d.panels.size(); ++i) {
    const PanelDeviationT& p = *d.panels[i];
    EXPECT_EQ(json["panels"][i]["verdict"], word(p.verdict));
    EXPECT_EQ(panels.at(p.guid), ifc::label_of(p.verdict));
    EXPECT_EQ(page_panels.at(p.name), spaced(p.verdict));
    const std::string panel_case = "<testcase classname=\"panels\" name=\"" + p.name + "\"";
    const std::size_t panel_at = junit.find(panel_case);
    ASSERT_NE(panel_at, std::string::npos) << p.name;
    const std::string panel_rest = junit.substr(panel_at + panel_case.size(), 60);
    EXPECT_EQ(panel_rest.starts_with("/>"), p.verdict == ToleranceVerdict::pass) << p.name;
    EXPECT_EQ(panel_rest.find("type=\"" + word(p.verdict)) != std::string::npos,
              p.verdict >= ToleranceVerdict::undecided)
        << p.name;
    EXPECT_EQ(bcf.find("<Selection><Component IfcGuid=\"" + p.guid + "\"") != std::string::npos,
              p.verdict >= ToleranceVerdict::undecided);
    for (const auto& fixing : p.fixings)  // never better than its anchors
      for (const auto& a : d.anchors)
        if (a->id == fixing->anchor) {
          EXPECT_GE(p.verdict, a->verdict) << p.name;
        }
  }
  EXPECT_EQ(anchors.size(), static_cast<std::size_t>(std::count_if(d.anchors.begin(), d.anchors.end(),
                                                                   [](const auto& a) { return !a->guid.empty(); })));
  EXPECT_EQ(panels.size(), d.panels.size());
  int counts[4] = {};
  for (std::size_t i = 0; i < d.floors.size(); ++i) {
    const FloorDeviationT& f = *d.floors[i];
    EXPECT_EQ(json["deviation"]["floors"][i]["verdict"], word(f.verdict));
    if (const auto floor = floors.find(f.storey_guid); floor != floors.end()) {
      EXPECT_EQ(floor->second, ifc::label_of(f.verdict));
    }
    std::string told = spaced(f.verdict);
    for (const int n : {f.passed, f.undecided, f.failed, f.not_measured}) told += " " + std::to_string(n);
    if (!d.panels.empty())
      for (const int n : {f.panels_passed, f.panels_undecided, f.panels_failed}) told += " " + std::to_string(n);
    EXPECT_EQ(page_floors.at(f.floor > 0 ? std::to_string(f.floor) : "unknown"), told);
    counts[0] += f.not_measured, counts[1] += f.passed, counts[2] += f.undecided, counts[3] += f.failed;
  }
  EXPECT_EQ(counts[1], d.passed);
  EXPECT_EQ(counts[2] + counts[3], static_cast<int>(open));
  const std::string summary = report::summary_text(c.accuracy, &d);
  EXPECT_NE(summary.find("Anchors against the design: " + std::to_string(d.passed) + " pass, " +
                         std::to_string(d.undecided) + " undecided, " + std::to_string(d.failed) + " fail"),
            std::string::npos)
      << summary;
  if (!d.panels.empty()) {
    int of_panels[4] = {};
    for (const auto& panel : d.panels) ++of_panels[static_cast<int>(panel->verdict)];
    EXPECT_NE(summary.find("; panels: " + std::to_string(of_panels[1]) + " pass, " + std::to_string(of_panels[2]) +
                           " undecided, " + std::to_string(of_panels[3]) + " fail"),
              std::string::npos)
        << summary;
  }
}

}  // namespace plumbline::judgement
