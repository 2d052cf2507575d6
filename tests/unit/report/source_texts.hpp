// The texts for readers in sources: string literals with words, as they stand there.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plumbline::report::test {

struct SourceText {
  std::string text;  ///< of adjacent literals, escapes resolved
  int line = 0;
};

/// Sources whose texts a page or the summary says, relative to the root of the tree.
std::vector<std::string> files_with_texts(const std::filesystem::path& root);

/// Literals that a reader may read: with a space or a capital, and not in what is thrown, nor names of classes,
/// attributes and the like.
std::vector<SourceText> texts_of(const std::filesystem::path& file);

/// Its words between places such as {:.1f}; those without letters are left out.
std::vector<std::string> words_between_places(const std::string& text);

}  // namespace plumbline::report::test
