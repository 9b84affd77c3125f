#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/map/maximum_pyramid.hpp"

namespace matchbox_slam {

/// Part of the field's likelihoods, or of one level of their bounds, as one contiguous table of the
/// values that a search gives them, so that a look-up is one addition and rows can be read whole.
class FieldWindow {
 public:
  using Values = std::array<std::uint8_t, 256>;

  /// Rows may be read this far beyond their last entry.
  static constexpr int kPadding = 32;

  /// @param box     entries to copy.
  /// @param values  value of each likelihood.
  static FieldWindow of_likelihood(const LikelihoodField& field, const CellBox& box,
                                   const Values& values);
  static FieldWindow of_bounds(const LikelihoodField& field, int level, const CellBox& box,
                               const Values& values);

  /// The same entries, each together with the three above it: byte r of entry (x, y) is the entry
  /// (x, y + r), so that a window of 4 x 4 entries is 16 bytes in a row. What lies beyond is 0.
  [[nodiscard]] FieldWindow packed() const;

  static constexpr int kPackedRows = 4;

  /// Bytes of an entry: kPackedRows in a packed table, else 1.
  [[nodiscard]] int entry_bytes() const { return entry_bytes_; }

  /// The first entry.
  [[nodiscard]] const Cell& corner() const { return corner_; }
  [[nodiscard]] const std::uint8_t* data() const { return table_.data(); }
  /// Entries from row to row, whatever bytes they have.
  [[nodiscard]] std::ptrdiff_t pitch() const { return pitch_; }

 private:
  explicit FieldWindow(const CellBox& box);

  template <typename PlaneOf>
  void copy(const CellBox& box, const Values& values, const PlaneOf& plane_of);

  Cell corner_;
  std::int32_t pitch_;
  std::int32_t entry_bytes_ = 1;
  std::vector<std::uint8_t> table_;
};

}  // namespace matchbox_slam
