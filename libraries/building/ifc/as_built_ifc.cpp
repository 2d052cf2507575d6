#include "building/ifc/as_built_ifc.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "building/ifc/as_built_writer.hpp"
#include "building/ifc/doubt_words.hpp"
#include "building/ifc/shift_words.hpp"
#include "building/ifc/temperature_words.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::ifc {
namespace {

/// The comparison with the survey that is evidence: on check anchors; on control anchors if there are no others.
const AccuracyComparisonT* survey_comparison(const AccuracyT& accuracy) {
  const AccuracyComparisonT* found = nullptr;
  for (const auto& comparison : accuracy.comparisons) {
    if (comparison->reference != AccuracyReference::survey || comparison->anchors == 0) continue;
    if (!found || comparison->use == AnchorUse::check) found = comparison.get();
  }
  return found;
}

void require_same_file(const step::File& file, const DeviationT& deviation) {
  const auto check = [&](std::uint64_t number, const std::string& guid) {
    const auto instance = file.find(number);
    if (number == 0 || (instance && file.contains(*instance, guid))) return;
    throw std::runtime_error("the deviations were judged against " + deviation.design_file + ", in which #" +
                             std::to_string(number) + " is " + guid + "; in " + file.name() +
                             " it is not: connect all to the same design file");
  };
  for (const auto& anchor : deviation.anchors) check(anchor->instance, anchor->guid);
  for (const auto& panel : deviation.panels) check(panel->instance, panel->guid);
}

}  // namespace

AsBuiltWriter::AsBuiltWriter(const step::File& file, const Design& design, const DeviationT& deviation,
                             const AccuracyT& accuracy, const AsBuiltIfcOptions& options)
    : model_(file),
      design_(design),
      deviation_(deviation),
      accuracy_(accuracy),
      options_(options),
      appender_(model_, design.project_guid, design.length_unit, options.timestamp),
      products_(appender_, design, key_prefix_of(options.epoch)) {
  for (const auto& anchor : accuracy.anchors) residuals_[anchor->id] = anchor.get();
  for (const Storey& storey : design.storeys) storeys_[storey.guid] = &storey;
  for (const auto& floor : deviation.floors)
    if (const auto storey = storeys_.find(floor->storey_guid); storey != storeys_.end())
      floors_[floor->floor] = storey->second;
}

AsBuiltIfc AsBuiltWriter::write() {
  verdicts_ = appender_.enumeration("ASB_Verdict", {"PASS", "FAIL", "UNDECIDED", "NOTMEASURED"});
  roles_ = appender_.enumeration("ASB_Role", {"CONTROL", "CHECK", "NONE"});
  find_standard_sets();
  for (const auto& anchor : deviation_.anchors) {
    stop_point();
    write_anchor(*anchor);
  }
  write_provenance();
  write_judgement();
  if (const AccuracyComparisonT* comparison = survey_comparison(accuracy_)) {
    for (const auto& floor : comparison->floors) write_floor(*floor, *comparison);
    for (const auto& transfer : comparison->transfers)
      if (transfer->column == 0 && std::isfinite(transfer->error)) write_transfer(*transfer, *comparison);
    for (const auto& column : comparison->columns) write_column(*column, use_word(*comparison));
  }
  for (const auto& panel : deviation_.panels) {
    stop_point();
    write_panel(*panel);
  }
  write_surfaces();
  write_products();
  write_document();
  result_.additions = appender_.take_lines();
  result_.instances_added = appender_.count();
  return std::move(result_);
}

void AsBuiltWriter::write_provenance() {
  std::vector<InstanceId> objects;
  for (const auto& anchor : deviation_.anchors)
    if (anchor->instance != 0 && anchor->deviation.allFinite()) objects.push_back(anchor->instance);
  PropertySet set(appender_);
  for (const auto& [name, value] : options_.provenance) {
    if (name == "ObservationTime")
      set.date_time(name, value);
    else
      set.label(name, value);
  }
  if (options_.image_count >= 0) set.integer("ImageCount", options_.image_count, "Images that took part");
  if (options_.reading_count >= 0)
    set.integer("ReadingCount", options_.reading_count, "Readings of the survey that took part");
  if (options_.reading_count >= 0 && options_.readings_left_out > 0)
    set.integer("ReadingsLeftOut", options_.readings_left_out, "Readings that were read and left out");
  set.labels("InputSha256", options_.input_hashes, "Files that were read, with their SHA-256");
  set.labels("UnusedSha256", options_.unused_hashes,
             "Photographs and survey files that lay in the folder and were left out on purpose, with their SHA-256");
  if (!objects.empty() && !set.empty())
    attach(set, "anchors", "ASB_Provenance", "How the as-built values came about", objects);
}

/// The whole: on the project, where everybody finds it, and on the building, where viewers show it. Of several none has
/// what is true of all together: a faultless one would stand as failed.
void AsBuiltWriter::write_judgement() {
  const auto buildings = model_.all("IFCBUILDING");
  std::vector<InstanceId> on = {model_.all("IFCPROJECT").at(0).id()};
  if (buildings.size() == 1) on.push_back(buildings[0].id());
  std::vector<std::string> not_judged;
  for (const auto& request : deviation_.requests)
    if (!request->not_judged.empty()) not_judged.push_back(request->asked + ": " + request->not_judged);
  PropertySet set(appender_);
  set.choice("Verdict", label_of(deviation_.verdict), verdicts_, "PASS: ready to install");
  if (!deviation_.anchors.empty() || !deviation_.surfaces) {  // a scan measures none
    set.integer("AnchorsPassed", deviation_.passed);
    set.integer("AnchorsUndecided", deviation_.undecided);
    set.integer("AnchorsFailed", deviation_.failed);
    set.integer("AnchorsNotMeasured", deviation_.not_measured);
  }
  if (const auto& surfaces = deviation_.surfaces) {
    set.integer("SurfacesPassed", surfaces->passed, "Quantities of panels' surfaces and joints that keep their limits");
    set.integer("SurfacesUndecided", surfaces->undecided);
    set.integer("SurfacesFailed", surfaces->failed);
    set.integer("SurfacesNotJudged", surfaces->not_judged);
  }
  set.labels("NotJudged", not_judged, "What was asked for and could not be judged");
  set.labels("Doubts", in_words(deviation_.doubts), "Why the measurement is not to be trusted");
  set.labels("LessCertain", in_words(deviation_.misfits), "Why all standard deviations are larger");
  set.labels("Shifts", shift_words(deviation_), "What a floor, a facade, a column or the building has in common");
  if (!deviation_.datum.empty()) set.label("Datum", deviation_.datum, "What the place of the whole rests on");
  set.label("Temperature", temperature_words(deviation_), "What the judgement leaves out");
  set.real("Risk", deviation_.risk, "Pass: a conformance probability of 1 - risk or more");
  attach(set, "judgement", "ASB_Judgement", "As-built against design, all together", on);
}

void AsBuiltWriter::write_products() {
  if (!options_.survey_points && !options_.solids) return;
  if (!products_.possible()) {
    result_.warnings.push_back(
        "the design has no three-dimensional representation context, or no storey, building or site to contain "
        "anything; survey points and solids are not written");
    return;
  }
  std::map<std::uint64_t, const Element*> elements;
  for (const Element& element : design_.elements) elements[element.instance] = &element;
  const std::string when = options_.epoch.empty() ? "" : " " + options_.epoch;
  for (const auto& anchor : deviation_.anchors) {
    if (anchor->instance == 0 || !anchor->deviation.allFinite()) continue;
    if (options_.survey_points) products_.add_survey_point(*anchor, "As-built " + anchor->id + when);
    if (options_.solids) products_.add_marker(*anchor, "As-built " + anchor->id + when);
  }
  for (const auto& panel : deviation_.panels)
    if (const auto element = elements.find(panel->instance);
        options_.solids && element != elements.end() && element->second->has_box && panel->shift.allFinite())
      products_.add_panel(*panel, *element->second);
  products_.finish();
}

/// Who finds a value or a solid in the model finds where it comes from.
void AsBuiltWriter::write_document() {
  if (options_.document.empty()) return;
  std::set<InstanceId> objects = {model_.all("IFCPROJECT").at(0).id()};
  for (const auto& anchor : deviation_.anchors)
    if (anchor->instance != 0 && anchor->deviation.allFinite()) objects.insert(anchor->instance);
  for (const auto& panel : deviation_.panels)
    if (panel->instance != 0) objects.insert(panel->instance);
  objects.insert(products_.products().begin(), products_.products().end());
  std::vector<std::string> related;
  for (const InstanceId object : objects) related.push_back(step::reference(object));
  const std::string name = "As-built survey" + (options_.epoch.empty() ? "" : " " + options_.epoch);
  std::vector<std::string> reference = {step::text(options_.document), step::text("as-built/" + options_.epoch),
                                        step::text(name)};
  if (model_.schema() != Schema::ifc2x3)
    reference.insert(reference.end(), {step::text("Report of the measurement and the judgement"), step::null});
  appender_.add_root("IFCRELASSOCIATESDOCUMENT", key("document"), name, "Where what was added comes from",
                     {step::list(related), step::reference(appender_.add("IFCDOCUMENTREFERENCE", reference))});
}

const char* label_of(ToleranceVerdict verdict) {
  switch (verdict) {
    case ToleranceVerdict::pass:
      return "PASS";
    case ToleranceVerdict::undecided:
      return "UNDECIDED";
    case ToleranceVerdict::fail:
      return "FAIL";
    case ToleranceVerdict::not_measured:
      break;
  }
  return "NOTMEASURED";
}

AsBuiltIfc write_as_built(const step::File& file, const Design& design, const DeviationT& deviation,
                          const AccuracyT& accuracy, const AsBuiltIfcOptions& options) {
  if (design.project_guid.empty())
    throw std::runtime_error(file.name() +
                             ": found no IfcProject, expected one: as-built values need its units and its GlobalId");
  require_same_file(file, deviation);
  return AsBuiltWriter(file, design, deviation, accuracy, options).write();
}

void write_enriched(const step::File& file, const AsBuiltIfc& as_built, const std::filesystem::path& path) {
  const std::string_view design = file.bytes();
  errno = 0;
  std::ofstream stream(path, std::ios::binary);
  for (const std::string_view part :
       {design.substr(0, file.data_end()), std::string_view(as_built.additions), design.substr(file.data_end())})
    stream.write(part.data(), static_cast<std::streamsize>(part.size()));
  stream.close();
  if (!stream) throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(errno));
}

std::string enriched(const step::File& file, const AsBuiltIfc& as_built) {
  const std::string_view design = file.bytes();
  std::string all;
  all.reserve(design.size() + as_built.additions.size());
  all += design.substr(0, file.data_end());
  all += as_built.additions;
  all += design.substr(file.data_end());
  return all;
}

}  // namespace plumbline::ifc
