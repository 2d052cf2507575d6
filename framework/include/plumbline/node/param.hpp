// The parameters of a node.
#pragma once

#include <string>
#include <utility>

#include "plumbline/node/parameter_text.hpp"
#include "plumbline/node/ports.hpp"

namespace plumbline {

/// A parameter: double, any integer type, bool, std::string, FilePath, FolderPath, or a std::vector of them. `*height`
/// is its value. The bounds of a narrow integer type are bounds of the parameter, so its value always fits.
template <typename T>
class Node::Param {
  static_assert(detail::ParamKind<T>::known,
                "Param<T> takes double, an integer type, bool, std::string, FilePath, FolderPath, or a std::vector of "
                "one of them; in place of float write double, in place of const char* std::string");

 public:
  Param(const char* name, T fallback, const char* doc) : Param(name, fallback, "", Bounds{}, doc) {}
  Param(const char* name, T fallback, const char* unit, const char* doc) : Param(name, fallback, unit, Bounds{}, doc) {}
  Param(const char* name, T fallback, Bounds bounds, const char* doc) : Param(name, fallback, "", bounds, doc) {}
  Param(const char* name, T fallback, const char* unit, Bounds bounds, const char* doc)
      : default_(detail::to_text(fallback)) {
    declare(name, unit, bounds, doc, default_.c_str());
  }
  Param(const char* name, T fallback, Choices choices, const char* doc)
      : default_(detail::to_text(fallback)), choices_(std::move(choices)) {
    declare(name, "", {}, doc, default_.c_str());
  }
  Param(const char* name, Required, const char* doc) { declare(name, "", {}, doc, nullptr); }
  Param(const char* name, Required, const char* unit, Bounds bounds, const char* doc) {
    declare(name, unit, bounds, doc, nullptr);
  }
  Param(const char* name, Required, Choices choices, const char* doc) : choices_(std::move(choices)) {
    declare(name, "", {}, doc, nullptr);
  }
  const T& operator*() const { return value_; }
  const T* operator->() const { return &value_; }

 private:
  void declare(const char* name, const char* unit, Bounds bounds, const char* doc, const char* default_text) {
    bounds = detail::within_type<T>(bounds);
    param_ = {sizeof(plumbline_param),
              detail::ParamKind<T>::kind,
              detail::ParamKind<T>::is_list,
              static_cast<uint32_t>(choices_.values.size()),
              name,
              default_text,
              unit,
              doc,
              bounds.minimum,
              bounds.maximum,
              choices_.values.data()};
    detail::parts_under_construction->params.push_back(&param_);
    if (const plumbline_host* host = detail::host_of_this_run)
      if (const char* text = host->parameter(host->context, name)) detail::from_text(text, value_);
  }
  std::string default_;
  Choices choices_;
  plumbline_param param_{};
  T value_{};
};

}  // namespace plumbline
