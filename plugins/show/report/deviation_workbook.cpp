#include "show/report/deviation_workbook.hpp"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "building/ifc/doubt_words.hpp"
#include "building/judgement/worst_first.hpp"
#include "show/report/catalogue.hpp"

namespace plumbline::report {
namespace {

class Maker {
 public:
  Maker(const DeviationT& deviation, Language language) : deviation_(deviation), language_(language) {}

  std::vector<Sheet> all() const { return {anchors(), panels(), floors(), requests()}; }

 private:
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();

  /// In the language of the workbook. What the program does not know (a name of a rule) stays as it is.
  std::string word(const std::string& english) const {
    return language_ == Language::german ? german().find(english).value_or(english) : english;
  }
  std::string verdict(ToleranceVerdict verdict) const {
    const char* words[] = {"not measured", "pass", "undecided", "fail"};
    return word(words[static_cast<int>(verdict)]);
  }
  static double floor_of(int floor) { return floor > 0 ? floor : nan; }
  static std::string facade_of(const std::unique_ptr<FacadeFrameT>& frame) { return frame ? frame->facade : ""; }

  void head(Sheet& sheet, const std::string& text, int decimals) const {
    sheet.heads.push_back(word(text)), sheet.decimals.push_back(decimals);
  }

  Sheet anchors() const {
    Sheet sheet;
    sheet.name = word("Anchors");
    for (const char* text : {"Anchor", "GlobalId"}) head(sheet, text, 0);
    for (const char* text : {"Floor", "Facade", "Verdict", "Decided by"}) head(sheet, text, 0);
    head(sheet, "Within tolerance with", 3);
    const std::pair<const char*, const char*> axes[] = {{"horizontal", "Horizontal [mm]"},
                                                        {"vertical", "Height [mm]"},
                                                        {"in_plane", "In plane [mm]"},
                                                        {"out_of_plane", "Out of plane [mm]"},
                                                        {"space", "In space [mm]"}};
    for (const auto& [axis, text] : axes) {
      head(sheet, text, 2);
      sheet.heads.push_back(word(text) + " " + word("u")), sheet.decimals.push_back(2);
      sheet.heads.push_back(word(text) + " " + word("Tolerance")), sheet.decimals.push_back(2);
    }
    for (const char* text : {"dx [mm]", "dy [mm]", "dz [mm]"}) head(sheet, text, 2);
    for (const char* text : {"Design x [m]", "Design y [m]", "Design z [m]"}) head(sheet, text, 4);
    head(sheet, "Note", 0);
    for (const AnchorDeviationT* a : judgement::worst_first(deviation_)) {
      std::vector<SheetCell> row = {a->id,
                                    a->guid,
                                    floor_of(a->floor),
                                    facade_of(a->facade),
                                    verdict(a->verdict),
                                    word(a->decided_by),
                                    a->pass_probability};
      for (const auto& [axis, text] : axes) {
        const JudgedAxisT* found = nullptr;
        for (const auto& judged : a->axes)
          if (judged->axis == axis) found = judged.get();
        row.emplace_back(found ? 1e3 * found->value : nan);
        row.emplace_back(found ? 1e3 * found->u : nan);
        row.emplace_back(found && found->tolerance > 0 ? 1e3 * found->tolerance : nan);
      }
      for (int k = 0; k < 3; ++k) row.emplace_back(1e3 * a->deviation[k]);
      for (int k = 0; k < 3; ++k) row.emplace_back(a->design[k]);
      row.emplace_back(word(a->note));
      sheet.rows.push_back(std::move(row));
    }
    return sheet;
  }

  Sheet panels() const {
    Sheet sheet;
    sheet.name = word("Panels");
    for (const char* text : {"Panel", "GlobalId", "Floor", "Facade", "Verdict", "Decided by"}) head(sheet, text, 0);
    head(sheet, "Within tolerance with", 3);
    for (const char* text : {"Out of plane [mm]", "Sideways [mm]", "Height [mm]", "In plane [mm]"})
      head(sheet, text, 2);
    head(sheet, "Shims outward [mm]", 0), head(sheet, "Note", 0);
    for (const PanelDeviationT* p : judgement::worst_panels_first(deviation_)) {
      std::string shims;
      for (const auto& fixing : p->fixings) {
        if (!std::isfinite(fixing->shim)) continue;
        const std::string text = fmt::format(" {:+.1f}", 1e3 * fixing->shim);
        shims += (shims.empty() ? "" : "; ") + fixing->anchor + text;
      }
      const auto length = [](const std::unique_ptr<JudgedLengthT>& l) { return l ? 1e3 * l->value : nan; };
      sheet.rows.push_back({p->name.empty() ? p->guid : p->name, p->guid, floor_of(p->floor), facade_of(p->facade),
                            verdict(p->verdict), word(p->decided_by), p->pass_probability, length(p->out_of_plane),
                            length(p->sideways), length(p->vertical), length(p->in_plane), shims, word(p->reason)});
    }
    return sheet;
  }

  Sheet floors() const {
    Sheet sheet;
    sheet.name = word("Floors");
    for (const char* text : {"Floor", "Storey", "Verdict", "Anchors pass", "Anchors undecided", "Anchors fail",
                             "Anchors not measured", "Panels pass", "Panels undecided", "Panels fail"})
      head(sheet, text, 0);
    head(sheet, "All at once, at least", 3);
    for (const auto& f : deviation_.floors) {
      std::vector<SheetCell> row = {floor_of(f->floor), f->storey, verdict(f->verdict)};
      for (const int n : {f->passed, f->undecided, f->failed, f->not_measured, f->panels_passed, f->panels_undecided,
                          f->panels_failed})
        row.emplace_back(static_cast<double>(n));
      row.emplace_back(f->pass_together);
      sheet.rows.push_back(std::move(row));
    }
    return sheet;
  }

  Sheet requests() const {
    Sheet sheet;
    sheet.name = word("Asked for");
    for (const char* text : {"Asked for", "By", "Anchors", "Panels", "Not judged because"}) head(sheet, text, 0);
    for (const auto& r : deviation_.requests)
      sheet.rows.push_back({word(r->asked), word(r->by), static_cast<double>(r->anchors),
                            static_cast<double>(r->panels), word(r->not_judged)});
    for (const auto& doubt : deviation_.doubts)
      sheet.rows.push_back({std::string(), "", nan, nan, word(ifc::in_words(*doubt))});
    for (const auto& misfit : deviation_.misfits)  // judged, and less certain
      sheet.rows.push_back({word("Less certain, " + ifc::in_words(*misfit)), "", nan, nan, ""});
    return sheet;
  }

  const DeviationT& deviation_;
  Language language_;
};

}  // namespace

std::vector<Sheet> deviation_sheets(const DeviationT& deviation, Language language) {
  return Maker(deviation, language).all();
}

}  // namespace plumbline::report
