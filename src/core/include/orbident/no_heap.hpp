// Loops over samples allocate nothing. The sanitized build (EIGEN_RUNTIME_NO_MALLOC) stops where
// Eigen would allocate within the scope of a NoHeap; other builds are not changed by it. The switch
// is one for the whole process: the sanitized tests run on one processor.
#pragma once

#include <Eigen/Core>

namespace orbident {

struct NoHeap {
#ifdef EIGEN_RUNTIME_NO_MALLOC
  NoHeap() { Eigen::internal::set_is_malloc_allowed(false); }
  ~NoHeap() { Eigen::internal::set_is_malloc_allowed(true); }
#else
  NoHeap() {}
#endif
  NoHeap(const NoHeap&) = delete;
};

}  // namespace orbident
