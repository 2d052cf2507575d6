// What every bim_writer must do: put (14) and the residuals into the design file without touching what is in it.
#include "../unit/bim/small_building.hpp"
#include "artifacts/accuracy.hpp"
#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/file_artifact.hpp"
#include "building/step/step.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"

namespace bim_writer_tests {

using namespace plumbline;
using namespace plumbline::test;

const Eigen::Vector3d kDeviation(0.002, -0.003, 0.001);

FileT file_of(const std::string& bytes) {
  FileT file;
  file.name = "small.ifc";
  file.content.assign(bytes.begin(), bytes.end());
  return file;
}

/// A design, and deviations in which every anchor is off by kDeviation.
struct Problem {
  FileT file;
  DesignT design;
  DeviationT deviation;
  AccuracyT accuracy;

  explicit Problem(const std::string& bytes) : file(file_of(bytes)) {
    NodeHarness reader("bim.read_ifc");
    reader.input<plumbline::File>("file", file);
    reader.run();
    design = reader.output<Design>("design");
    accuracy.tau = 0.005;
    accuracy.guard_factor = 2;
    for (const auto& element : design.elements) {
      if (!element->is_anchor) continue;
      auto anchor = std::make_unique<AnchorDeviationT>();
      anchor->id = element->name, anchor->guid = element->guid, anchor->instance = element->instance;
      anchor->storey_guid = element->storey_guid, anchor->floor = element->name[1] - '0';
      anchor->design = element->position, anchor->deviation = kDeviation;
      anchor->as_built = element->position + kDeviation, anchor->target_offset.setZero();
      anchor->verdict = ToleranceVerdict::pass;
      deviation.anchors.push_back(std::move(anchor));
      accuracy.anchors.push_back(std::make_unique<AnchorAccuracyT>());
      accuracy.anchors.back()->id = element->name;
      accuracy.anchors.back()->floor = element->name[1] - '0';
      accuracy.anchors.back()->use = AnchorUse::check;
    }
  }
};

class BimWriter : public testing::TestWithParam<std::string> {
 protected:
  static NodeHarness prepared(const Problem& problem) {
    NodeHarness node(GetParam());
    node.input<plumbline::File>("design_file", problem.file);
    node.input<Design>("design", problem.design);
    node.input<Deviation>("deviation", problem.deviation);
    node.input<Accuracy>("accuracy", problem.accuracy);
    return node;
  }
  static std::string written(const Problem& problem) {
    NodeHarness node = prepared(problem);
    node.run();
    return file_bytes(node.output<plumbline::File>("file"), [](const std::string& uri) { return uri; });
  }

  /// The values of a length property, in the order of the file.
  static std::vector<double> lengths(const std::string& bytes, const std::string& property) {
    const step::File file(bytes, "written.ifc");
    std::vector<double> values;
    for (const auto index : file.of_type("IFCPROPERTYSINGLEVALUE")) {
      const auto arguments = file.arguments(file.instances()[index]);
      if (arguments.at(0).text == property) values.push_back(arguments.at(2).items.at(0).number);
    }
    return values;
  }
};

TEST_P(BimWriter, KeepsEveryLineOfTheDesignInOrder) {
  for (const char* schema : {"IFC2X3", "IFC4", "IFC4X3"}) {
    const std::string before = small_building(schema);
    std::istringstream old_lines(before), new_lines(written(Problem(before)));
    std::string wanted, line;
    while (std::getline(old_lines, wanted)) {
      bool found = false;
      while (!found && std::getline(new_lines, line)) found = line == wanted;
      ASSERT_TRUE(found) << schema << ": " << wanted;
    }
  }
}

TEST_P(BimWriter, RecordsTheDeviationsInTheUnitOfTheProject) {
  for (const auto& [unit, metres] : {std::pair{"#11=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);", 1e-3},
                                     std::pair{"#11=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);", 1.0}}) {
    const Problem problem(small_building("IFC4", "", unit));
    const std::string bytes = written(problem);
    for (const auto& [property, expected] :
         {std::pair{"DeviationX", kDeviation.x()}, std::pair{"DeviationY", kDeviation.y()},
          std::pair{"DeviationZ", kDeviation.z()}}) {
      const std::vector<double> found = lengths(bytes, property);
      ASSERT_EQ(found.size(), problem.deviation.anchors.size()) << property;
      for (const double value : found) EXPECT_NEAR(value * metres, expected, 2e-9) << property;
    }
  }
}

TEST_P(BimWriter, GivesTheSameBytesTwice) {
  const Problem problem(small_building("IFC4"));
  EXPECT_EQ(written(problem), written(problem));
}

TEST_P(BimWriter, TakesADesignThatIsNamedAndSeesThatItChanged) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "tower.ifc").string();
  for (const char* schema : {"IFC4", "IFC2X3"}) {
    Problem problem(small_building(schema));
    const std::string expected = written(problem);
    std::ofstream(path, std::ios::binary) << small_building(schema);
    problem.file.content.clear(), problem.file.uri = path;
    EXPECT_EQ(written(problem), expected) << schema;
    EXPECT_EQ(written(problem), expected) << schema;
    EXPECT_EQ(read_file(path), small_building(schema));
  }
}

TEST_P(BimWriter, RefusesADesignOfAnotherFileAndDamage) {
  Problem other(small_building("IFC4"));
  for (auto& anchor : other.deviation.anchors) anchor->instance += 1;
  EXPECT_THROW(written(other), NodeFailed);
  Problem cut(small_building("IFC4"));
  cut.file.content.resize(cut.file.content.size() / 2);
  EXPECT_THROW(written(cut), NodeFailed);
}

TEST_P(BimWriter, EveryParameterHasItsEffect) {
  const Problem problem(small_building("IFC4"));
  EXPECT_EQ(parameters_at_fault({[&] { return prepared(problem); }}), "");
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(BimWriter);
INSTANTIATE_TEST_SUITE_P(Role, BimWriter, testing::ValuesIn(kinds_of_role("bim_writer")), test_name);

}  // namespace bim_writer_tests
