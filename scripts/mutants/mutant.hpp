// What scripts/mutate writes into its copy of the sources: a place that can be wrong asks here whether it is to be.
// PLUMBLINE_MUTANT=FILE:N of the environment makes the place N of FILE wrong; PLUMBLINE_MUTANTS_SEEN=LOG lists the
// places that a run comes past. Included once by each file, after its own name PLUMBLINE_MUTANTS_OF.
#include <fcntl.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <string>
#include <type_traits>

namespace {
namespace mutants {

constexpr int kMost = 4096;
inline std::atomic<int> chosen{-2};
inline int seen_log = -1;
inline std::atomic<bool> seen[kMost];

inline int read_choice() {
  if (const char* log = std::getenv("PLUMBLINE_MUTANTS_SEEN"))
    seen_log = ::open(log, O_WRONLY | O_CREAT | O_APPEND, 0644);
  const char* mutant = std::getenv("PLUMBLINE_MUTANT");
  const std::string text = mutant ? mutant : "", file = PLUMBLINE_MUTANTS_OF ":";
  return text.compare(0, file.size(), file) == 0 ? std::atoi(text.c_str() + file.size()) : -1;
}

inline bool on(int n) {
  if (chosen == -2) chosen = read_choice();
  if (seen_log >= 0 && !seen[n].exchange(true)) {
    const std::string line = PLUMBLINE_MUTANTS_OF ":" + std::to_string(n) + "\n";
    if (::write(seen_log, line.data(), line.size()) < 0) std::abort();
  }
  return n == chosen;
}

/// A place whose types leave nothing to be wrong is told of when the program starts, whether or not it is come past.
inline bool tell_that_it_is_none(int n) {
  on(n);
  const std::string line = PLUMBLINE_MUTANTS_OF ":" + std::to_string(n) + ":none\n";
  if (seen_log >= 0 && ::write(seen_log, line.data(), line.size()) < 0) std::abort();
  return true;
}
template <int N>
inline const bool none = tell_that_it_is_none(N);

template <typename T>
inline constexpr bool is_eigen = requires(const T& x) {
  x.derived();
  x.rows();
};
template <typename T>
inline constexpr bool is_number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool> && !std::is_same_v<T, char>;
template <typename T>
using Plain = typename T::PlainObject;

/// The other sign.
template <int N, typename T>
decltype(auto) flip(const T& x) {
  if constexpr (is_eigen<T> && requires { Plain<T>(-1.0 * x); }) {
    return Plain<T>((on(N) ? -1.0 : 1.0) * x);
  } else if constexpr (is_number<T> || (std::is_class_v<T> && requires { static_cast<T>(-x); })) {
    return on(N) ? static_cast<T>(-x) : x;
  } else {
    (void)none<N>;
    return (x);
  }
}

/// 1 / x for x.
template <int N, typename T>
decltype(auto) invert(const T& x) {
  if constexpr (std::is_floating_point_v<T>) {
    return on(N) ? 1 / x : x;
  } else {
    (void)none<N>;
    return (x);
  }
}

template <int N, typename T>
auto sqrt(const T& x) {
  using std::sqrt;
  return on(N) ? static_cast<decltype(sqrt(x))>(x) : sqrt(x);
}
template <int N, typename T>
auto abs(const T& x) {
  using std::abs;
  return on(N) ? static_cast<decltype(abs(x))>(x) : abs(x);
}
template <int N>
double cos(double x) {
  return on(N) ? std::sin(x) : std::cos(x);
}
template <int N>
double sin(double x) {
  return on(N) ? std::cos(x) : std::sin(x);
}
template <int N>
double atan2(double y, double x) {
  return on(N) ? std::atan2(x, y) : std::atan2(y, x);
}
template <int N>
double hypot(double x, double y) {
  return on(N) ? std::abs(x) : std::hypot(x, y);
}
template <int N>
double hypot(double x, double y, double z) {
  return on(N) ? std::hypot(x, y) : std::hypot(x, y, z);
}
template <int N, typename T>
T clamp(const T& x, const T& low, const T& high) {
  return on(N) ? x : std::clamp(x, low, high);
}
template <int N, typename T>
T max(const T& a, const T& b) {
  return on(N) ? std::min(a, b) : std::max(a, b);
}
template <int N, typename T>
T min(const T& a, const T& b) {
  return on(N) ? std::max(a, b) : std::min(a, b);
}

template <int N, typename T>
auto norm(const T& x) {
  return on(N) ? x.squaredNorm() : x.norm();
}
template <int N, typename T>
auto squared_norm(const T& x) {
  return on(N) ? x.norm() : x.squaredNorm();
}
template <int N, typename T>
auto transpose(const T& x) {
  if constexpr (requires {
                  requires int(T::RowsAtCompileTime) == int(T::ColsAtCompileTime) && int(T::RowsAtCompileTime) > 1;
                }) {
    return on(N) ? Plain<T>(x) : Plain<T>(x.transpose());
  } else {
    (void)none<N>;
    return x.transpose();
  }
}
template <int N, typename T>
auto inverse(const T& x) {
  if constexpr (is_eigen<T>) {
    return on(N) ? Plain<T>(x) : Plain<T>(x.inverse());
  } else if constexpr (requires { std::decay_t<decltype(x.inverse())>(x); }) {
    return on(N) ? std::decay_t<decltype(x.inverse())>(x) : x.inverse();
  } else {
    (void)none<N>;
    return x.inverse();
  }
}

/// The other of two arguments of one kind.
template <int N, typename T, typename U>
T&& other(T&& own, U&& other) {
  if constexpr (std::is_same_v<T, U>) {
    return on(N) ? static_cast<T&&>(other) : static_cast<T&&>(own);
  } else {
    (void)none<N>;
    return static_cast<T&&>(own);
  }
}

/// `a < less(n) < b` is a < b, and a >= b where it is wrong.
enum class Relation { less, greater, at_most, at_least, equal, unequal };
template <Relation>
struct Compare {
  int n;
};
template <typename T>
struct Side {
  const T& value;
  int n;
};
#define PLUMBLINE_RELATION(NAME, OPERATOR)                           \
  template <typename T>                                              \
  Side<T> operator OPERATOR(const T& a, Compare<Relation::NAME> c) { \
    return {a, c.n};                                                 \
  }                                                                  \
  template <typename T, typename U>                                  \
  bool operator OPERATOR(Side<T> a, const U& b) {                    \
    return on(a.n) != static_cast<bool>(a.value OPERATOR b);         \
  }
PLUMBLINE_RELATION(less, <)
PLUMBLINE_RELATION(greater, >)
PLUMBLINE_RELATION(at_most, <=)
PLUMBLINE_RELATION(at_least, >=)
PLUMBLINE_RELATION(equal, ==)
PLUMBLINE_RELATION(unequal, !=)
#undef PLUMBLINE_RELATION

}  // namespace mutants
}  // namespace
