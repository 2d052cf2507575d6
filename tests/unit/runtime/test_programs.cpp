// What a key holds of programs that a node starts, and of libraries: what they are, not how they are called.
#include <dlfcn.h>
#include <gnu/libc-version.h>
#include <stdlib.h>

#include <algorithm>
#include <map>

#include "runtime/base/digest.hpp"
#include "runtime/plugins/elf.hpp"
#include "runtime/plugins/programs.hpp"
#include "story.hpp"

extern "C" int nameless(), unsigned_by_the_linker();

namespace plumbline::test {
namespace test_programs {

namespace fs = std::filesystem;

/// A program of that name comes first on PATH as long as this lives.
class OnPath {
 public:
  OnPath() : before_(getenv("PATH")) { setenv("PATH", (folder_.path().string() + ":" + before_).c_str(), 1); }
  ~OnPath() { setenv("PATH", before_.c_str(), 1); }
  fs::path put(const std::string& name, const std::string& lines) const {
    std::ofstream(folder_.path() / name) << "#!/bin/sh\n" << lines << "\n";
    fs::permissions(folder_.path() / name, fs::perms::owner_all);
    return folder_.path() / name;
  }

 private:
  TemporaryFolder folder_;
  std::string before_;
};

TEST(Programs, AnotherProgramOfTheSameNameRunsTheNodeAgain) {
  const OnPath path;
  Story story("t: {use: story.teller}");
  story.run();
  EXPECT_EQ(story.value("t", "number"), 127) << "there is none";
  EXPECT_EQ(story.node("t").fields.at("parameter program"), "storyteller not installed");
  const fs::path program = path.put("storyteller", "exit 3");
  story.run();
  EXPECT_EQ(story.value("t", "number"), 3);
  EXPECT_EQ(story.node("t")
                .fields.at("parameter program")
                .find("storyteller sha256:" + runtime::sha256_of_file(program) + " says:"),
            0u);
  EXPECT_EQ(story.graph.nodes[0].parameters.at("program"), program.string());
  story.run();
  EXPECT_EQ(story.status("t"), "reused");
  path.put("storyteller", "exit 4");
  EXPECT_EQ(story.plan()[0].reasons.size(), 1u);
  story.run();
  EXPECT_EQ(story.value("t", "number"), 4);
  const fs::path other = path.put("other", "exit 5");
  story.run({"t.with.program=other"});
  EXPECT_EQ(story.value("t", "number"), 5) << "by another name on PATH";
  story.run({"t.with.program=" + other.string()});
  EXPECT_EQ(story.status("t"), "reused") << "by its path";
  EXPECT_THROW(story.run({"t.with.program=no_such_program"}), runtime::InvalidPipeline);
}

/// A colmap that conda, a module or docker puts on PATH is a script: what stands behind it was in no key, so results of
/// a program that always failed were taken over. Asked in processes of their own, as runs are.
TEST(Programs, WhatStandsBehindAScriptCountsByWhatItSays) {
  const OnPath path;
  const fs::path behind = path.put("behind", "echo 'Teller 3.8'");
  const fs::path wrapper = path.put("storyteller", "exec " + behind.string() + " \"$@\"");
  const TemporaryFolder folder;
  const auto field = [&](const std::string& name) {  // of another path: a process asks each once
    const fs::path copy = folder.path() / name;
    fs::copy_file(wrapper, copy);
    runtime::FileHashes files(folder.path() / "file-hashes");
    return runtime::program_field(copy.string(), files);
  };
  const std::string before = field("a");
  EXPECT_EQ(before.find("sha256:" + runtime::sha256_of_file(wrapper) + " says:"), 0u) << before;
  EXPECT_EQ(before, field("b"));
  path.put("behind", "echo 'Teller 3.9'");
  const std::string other = field("c");
  EXPECT_NE(before, other);
  path.put("behind", "echo 'Teller 3.9'; exit 1");
  EXPECT_NE(other, field("d")) << "one that fails";
  EXPECT_TRUE(runtime::is_script(wrapper));
  EXPECT_FALSE(runtime::is_script("/bin/true"));
}

/// Of a program that is no script also the libraries that it gets from the loader.
TEST(Programs, LibrariesOfAProgramCount) {
  const TemporaryFolder folder;
  runtime::FileHashes files(folder.path() / "file-hashes");
  const std::string field = runtime::program_field("/bin/true", files);
  EXPECT_EQ(field.find("sha256:" + runtime::sha256_of_file("/bin/true") + " libraries:"), 0u) << field;
  EXPECT_EQ(field, runtime::program_field("/bin/true", files));
  // An empty list would be the same for every program; this one has one more.
  const std::string other = runtime::program_field(fs::read_symlink("/proc/self/exe").string(), files);
  EXPECT_NE(field.substr(field.find("libraries")), other.substr(other.find("libraries")));
}

/// A library without a build id is told by its content, and one without a soname is found by its file's name.
TEST(Libraries, WithoutABuildIdCountByContent) {
  ASSERT_EQ(nameless() + unsigned_by_the_linker(), 3);
  const auto ids = runtime::linked_build_ids(reinterpret_cast<const void*>(&story_registry));
  for (const char* path : {PLUMBLINE_NAMELESS, PLUMBLINE_UNSIGNED}) {
    const std::string expected = fs::path(path).filename().string() + ":sha256-" + runtime::sha256_of_file(path);
    EXPECT_EQ(std::count(ids.begin(), ids.end(), expected), 1) << expected;
  }
  for (const std::string& id : ids) {
    if (!id.starts_with("C library:")) {
      EXPECT_GT(id.size() - id.rfind(':'), 16u) << id;
    }
  }
}

/// A security update of the C library makes new builds of all its parts; keys hold its release and the bits that libm
/// gives.
TEST(Libraries, TheCLibraryCountsByItsReleaseAndLibmByItsResults) {
  const auto ids = runtime::linked_build_ids(reinterpret_cast<const void*>(&story_registry));
  std::map<std::string, std::string> counting;
  for (const std::string& id : ids)
    if (!id.ends_with(runtime::kNoPartOfKeys)) counting[id.substr(0, id.rfind(':'))] = id.substr(id.rfind(':') + 1);
  for (const char* name : {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}) {
    EXPECT_EQ(counting.count(name), 0u) << name;
    EXPECT_TRUE(std::any_of(ids.begin(), ids.end(), [&](const auto& id) { return id.starts_with(name); }))
        << name;  // records have the build
  }
  EXPECT_EQ(counting.at("C library"), std::string("glibc ") + gnu_get_libc_version());
  EXPECT_EQ(counting.at("results of libm").size(), 64u);
  EXPECT_EQ(counting.count("libstdc++.so.6"), 1u);
}

/// PROJ can fetch grids: what brings them has no part in a number. SQLite, which reads its tables, has.
TEST(Libraries, WhatOnlyFetchesOrShowsIsNoPartOfKeys) {
  void* proj = dlopen("libproj.so.25", RTLD_NOW | RTLD_LOCAL);
  if (!proj) GTEST_SKIP() << "no libproj.so.25 here: " << dlerror();
  std::map<std::string, bool> counts;
  for (const std::string& id : runtime::linked_build_ids(dlsym(proj, "proj_create")))
    counts[id.substr(0, id.find('.'))] = !id.ends_with(runtime::kNoPartOfKeys);
  // PROJ itself needs libcurl: it counts, and all behind it as well.
  EXPECT_TRUE(counts.at("libsqlite3"));
  EXPECT_TRUE(counts.at("libcurl-gnutls"));
  // For what needs PROJ neither does.
  void* user = dlopen(PLUMBLINE_SURVEY_PLUGIN, RTLD_NOW | RTLD_LOCAL);
  ASSERT_TRUE(user) << dlerror();
  counts.clear();
  for (const std::string& id : runtime::linked_build_ids(dlsym(user, "plumbline_plugin")))
    counts[id.substr(0, id.find('.'))] = !id.ends_with(runtime::kNoPartOfKeys);
  for (const char* name : {"libproj", "libsqlite3", "libtiff"}) EXPECT_TRUE(counts.at(name)) << name;
  for (const char* name : {"libcurl-gnutls", "libgnutls", "libssh2", "libkrb5"}) EXPECT_FALSE(counts.at(name)) << name;
}

}  // namespace test_programs
}  // namespace plumbline::test
