// Every plugin exports exactly one symbol, carries its identity note, and is accepted by the host.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>

#include "runtime/plugins/registry.hpp"
#include "test_support.hpp"

namespace test_exports {

namespace fs = std::filesystem;

std::vector<fs::path> built_plugins() {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(fs::path(plumbline::test::binary_dir()) / "lib/plumbline"))
    if (entry.path().extension() == ".so") found.push_back(entry.path());
  return found;
}

std::string output_of(const std::string& command) {
  std::string text;
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
  std::array<char, 256> buffer;
  while (pipe && std::fgets(buffer.data(), buffer.size(), pipe.get())) text += buffer.data();
  return text;
}

TEST(Plugins, ExportOneSymbolOnly) {
  ASSERT_FALSE(built_plugins().empty());
  for (const fs::path& library : built_plugins())
    EXPECT_EQ(output_of("nm -D --defined-only --format=just-symbols '" + library.string() + "'"), "plumbline_plugin\n")
        << library;
}

TEST(Plugins, CarryTheirIdentityAndAreAccepted) {
  for (const fs::path& library : built_plugins()) {
    const auto identity = plumbline::runtime::read_identity(library);
    EXPECT_EQ(identity.problem, "") << library;
    EXPECT_EQ("plumbline_" + identity.name + ".so", library.filename().string());
    // Debian's Ceres brings parts of SuiteSparse that are under the GPL; its plugin says so
    // (tests/integration/licences).
    EXPECT_EQ(identity.licence, identity.name == "adjust_ceres" ? "MIT; GPL-2.0-or-later as linked" : "MIT");
  }
  const auto registry =
      plumbline::runtime::Registry::discover({fs::path(plumbline::test::binary_dir()) / "lib/plumbline"});
  for (const auto& refused : registry.refused()) ADD_FAILURE() << refused.path << " " << refused.problem;
}

TEST(Plugins, EveryNodeAndEveryPortAndParameterIsDocumented) {
  const auto registry =
      plumbline::runtime::Registry::discover({fs::path(plumbline::test::binary_dir()) / "lib/plumbline"});
  for (const auto& [name, kind] : registry.kinds()) {
    EXPECT_GT(std::string(kind.node->summary).size(), 10u) << name;
    for (uint32_t i = 0; i < kind.node->input_count; ++i) EXPECT_STRNE(kind.node->inputs[i]->doc, "") << name;
    for (uint32_t i = 0; i < kind.node->output_count; ++i) EXPECT_STRNE(kind.node->outputs[i]->doc, "") << name;
    for (uint32_t i = 0; i < kind.node->param_count; ++i) EXPECT_STRNE(kind.node->params[i]->doc, "") << name;
  }
}

/// Nodes of one role can stand in for each other: same ports, same types, same frames; what a node has beyond them is
/// optional.
TEST(Plugins, NodesOfOneRoleHaveTheSamePorts) {
  const auto registry =
      plumbline::runtime::Registry::discover({fs::path(plumbline::test::binary_dir()) / "lib/plumbline"});
  std::map<std::string, std::pair<std::string, std::string>> first;  // role -> (kind, ports)
  for (const auto& [name, kind] : registry.kinds()) {
    if (!*kind.node->role) continue;
    std::string ports;
    for (uint32_t i = 0; i < kind.node->input_count; ++i)
      if (kind.node->inputs[i]->cardinality != PLUMBLINE_OPTIONAL &&
          !registry.roles().may_lack(*kind.node, kind.node->inputs[i]->name))
        ports += std::string("in ") + kind.node->inputs[i]->name + " " + kind.node->inputs[i]->type + " " +
                 kind.node->inputs[i]->frames + " " + std::to_string(kind.node->inputs[i]->cardinality) + "\n";
    for (uint32_t i = 0; i < kind.node->output_count; ++i)
      ports += std::string("out ") + kind.node->outputs[i]->name + " " + kind.node->outputs[i]->type + " " +
               kind.node->outputs[i]->frames + "\n";
    const auto [entry, fresh] = first.emplace(kind.node->role, std::make_pair(name, ports));
    EXPECT_EQ(ports, entry->second.second)
        << name << " and " << entry->second.first << " share the role " << kind.node->role;
    // The first word of a kind is what it does; so what can stand in for each other stands together in `list`.
    EXPECT_EQ(name.substr(0, name.find('.')), entry->second.first.substr(0, entry->second.first.find('.')))
        << "kinds of the role " << kind.node->role << " begin with one word";
  }
}

}  // namespace test_exports
