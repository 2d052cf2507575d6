// YAML of one document. yaml-cpp reads the first of several and says nothing of the others.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

namespace plumbline::text {

/// Throws YAML::ParserException, with its place if a second document stands in the text. A line without its colon ends
/// a document as `---` does, so that is said where nobody wrote one.
inline YAML::Node load_one_document(const std::string& text) {
  const std::vector<YAML::Node> documents = YAML::LoadAll(text);
  const bool marked = text.rfind("---", 0) == 0 || text.find("\n---") != std::string::npos;
  for (size_t i = 1; i < documents.size(); ++i)
    if (!documents[i].IsNull())
      throw YAML::ParserException(documents[i].Mark(),
                                  marked ? "a second YAML document begins here (after ---), and nothing of it would be "
                                           "read; give it a file of its own, or take the --- away"
                                         : "what stands before this is not written as `key: value`; look for a line "
                                           "without its colon, or without the blank behind it");
  return documents.empty() ? YAML::Node() : documents[0];
}

}  // namespace plumbline::text
