// Part of camera_files.cpp: values of a camera file, whether it is YAML, JSON or XML.
#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <vector>

namespace plumbline::cameras::camera_file {

/// Throws std::runtime_error: the file, what is wrong with it, and which files are read.
[[noreturn]] void refuse(const std::string& file, const std::string& what);

/// The same of one value: "line 4 has '[752, PNG480]', expected ...".
[[noreturn]] void refuse_value(const std::string& file, const YAML::Node& node, const std::string& expected);

/// The file as a tree; `file` is its name, for messages.
YAML::Node parse(const std::string& text, const std::string& file);

/// Letters and digits only, small.
std::string simple(const std::string& key);

/// The first value under one of the names, wherever it stands; names as simple() has them.
YAML::Node find(const YAML::Node& node, const std::vector<std::string>& names, int depth = 0);

/// All numbers of a matrix, whether a list, a list of lists, or {rows, cols, data}.
std::vector<double> numbers(const YAML::Node& node);

/// A number of pixels: 0 to 10^6, rounded down.
std::optional<int> whole(double value);
std::optional<int> whole(const YAML::Node& node);

/// One finite number, of which a refusal says what it is.
double number(const YAML::Node& node, const std::string& file, const std::string& of);

}  // namespace plumbline::cameras::camera_file
