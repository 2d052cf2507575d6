// YAML of one document. yaml-cpp reads the first of several and says nothing of the others.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

namespace plumbline::text {

/// Throws YAML::ParserException, with its place if a second document stands in the text.
inline YAML::Node load_one_document(const std::string& text) {
  const std::vector<YAML::Node> documents = YAML::LoadAll(text);
  for (size_t i = 1; i < documents.size(); ++i)
    if (!documents[i].IsNull())
      throw YAML::ParserException(documents[i].Mark(),
                                  "a second YAML document begins here (after ---), and nothing of it would be read; "
                                  "give it a file of its own, or take the --- away");
  return documents.empty() ? YAML::Node() : documents[0];
}

}  // namespace plumbline::text
