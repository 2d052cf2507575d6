// What write_as_built works with; private to ifc/as_built_*.cpp: anchors, floors and panels each have a file.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/as_built_solids.hpp"
#include "building/ifc/ifc_appender.hpp"

namespace plumbline::ifc {

/// "check" or "control": which anchors a comparison is made of.
std::string use_word(const AccuracyComparisonT& comparison);

class AsBuiltWriter {
 public:
  AsBuiltWriter(const step::File& file, const Design& design, const DeviationT& deviation, const AccuracyT& accuracy,
                const AsBuiltIfcOptions& options);
  AsBuiltIfc write();

 private:
  std::string key(const std::string& what) const { return options_.epoch.empty() ? what : options_.epoch + "/" + what; }
  /// Names of sets are unique on an object, so every epoch has its own.
  std::string set_name(const std::string& name) const {
    return options_.epoch.empty() ? name : name + "_" + options_.epoch;
  }
  void attach(PropertySet& set, const std::string& what, const std::string& name, const std::string& description,
              const std::vector<InstanceId>& objects) {
    set.label("Epoch", options_.epoch);
    set.attach(key(what), set_name(name), description, objects);
  }

  void write_anchor(const AnchorDeviationT& anchor);
  void find_standard_sets();
  void write_standard_sets(const AnchorDeviationT& anchor, const std::vector<InstanceId>& object);
  void write_residual(const AnchorAccuracyT& measured, const AnchorDeviationT& anchor,
                      const std::vector<InstanceId>& object);
  void write_uncertainty(const AnchorDeviationT& anchor, const std::vector<InstanceId>& object);
  void write_provenance();
  void write_judgement();
  const Storey* storey_of(int floor);
  void write_floor(const FloorAccuracyT& floor, const AccuracyComparisonT& comparison);
  void write_transfer(const HeightTransferT& transfer, const AccuracyComparisonT& comparison);
  void write_column(const ColumnDriftT& column, const std::string& use);
  std::pair<double, double> heights_between(int lower, int upper) const;
  void write_panel(const PanelDeviationT& panel);
  void write_surfaces();
  void write_products();
  void write_document();

  Model model_;
  const Design& design_;
  const DeviationT& deviation_;
  const AccuracyT& accuracy_;
  const AsBuiltIfcOptions& options_;
  Appender appender_;
  ProductWriter products_;
  AsBuiltIfc result_;
  InstanceId verdicts_ = 0, roles_ = 0;
  std::map<std::string, const AnchorAccuracyT*> residuals_;
  std::map<std::string, const Storey*> storeys_;
  std::map<int, const Storey*> floors_;
  std::set<int> missing_floors_;
  std::set<std::pair<InstanceId, std::string>> standard_sets_;
};

}  // namespace plumbline::ifc
