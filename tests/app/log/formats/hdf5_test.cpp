// SPDX-License-Identifier: MIT
// HDF5 as h5py, MATLAB 7.3 and Octave write it; the library writes what is read here.
#include <gtest/gtest.h>

#include "recorded.h"

#if GYROBUDGET_HAS_HDF5
#include <hdf5.h>
#endif

namespace gyrobudget::app_tests {
namespace {

using Hdf5 = RecordingTest;

#if GYROBUDGET_HAS_HDF5

/// Writes a file, closed when it is destroyed.
class Writer {
 public:
  explicit Writer(const std::string& path, hsize_t user_block = 0) {
    const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
    H5Pset_userblock(creation, user_block);
    file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, H5P_DEFAULT);
    H5Pclose(creation);
  }
  ~Writer() { H5Fclose(file_); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void group(const std::string& path) {
    H5Gclose(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  }
  template <class Number>
  void set(const std::string& path, const std::vector<hsize_t>& dimensions, const std::vector<Number>& values,
           const std::vector<hsize_t>& chunk = {}, hid_t stored = -1) {
    const hid_t type = std::is_same_v<Number, double>         ? H5T_NATIVE_DOUBLE
                       : std::is_same_v<Number, std::int64_t> ? H5T_NATIVE_INT64
                                                              : H5T_NATIVE_UINT16;
    const hid_t space = dimensions.empty()
                            ? H5Screate(H5S_SCALAR)
                            : H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    if (!chunk.empty()) {
      H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
      H5Pset_deflate(creation, 4);
    }
    const hid_t data =
        H5Dcreate2(file_, path.c_str(), stored < 0 ? type : stored, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    if (!values.empty()) H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(data), H5Pclose(creation), H5Sclose(space);
  }
  void attribute(const std::string& path, const std::string& name, const std::string& value, bool nul_padded = false) {
    const hid_t object = H5Oopen(file_, path.c_str(), H5P_DEFAULT), space = H5Screate(H5S_SCALAR),
                type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, value.size() + (nul_padded ? 0 : 1));
    H5Tset_strpad(type, nul_padded ? H5T_STR_NULLPAD : H5T_STR_NULLTERM);
    const hid_t attribute = H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, value.c_str());
    H5Aclose(attribute), H5Tclose(type), H5Sclose(space), H5Oclose(object);
  }
  [[nodiscard]] hid_t id() const { return file_; }

 private:
  hid_t file_;
};

std::vector<double> counted_up(std::size_t count) {
  std::vector<double> values(count);
  std::iota(values.begin(), values.end(), 0.);
  return values;
}

TEST_F(Hdf5, GroupsOfEachLayout) {
  const std::string path = this->path("log.h5");
  constexpr hsize_t kRows = 5000;
  {
    Writer file(path);
    file.group("/synced");
    file.set("/synced/time", {kRows}, counted_up(kRows));
    file.set("/synced/gyro", {kRows, 3}, counted_up(3 * kRows), {64, 2});
    file.set("/synced/turned", {3, kRows}, counted_up(3 * kRows), {3, 700});
    file.set("/synced/big", {kRows, 1}, std::vector<std::int64_t>(kRows, (1LL << 53) + 3));
    file.set("/synced/few", {7}, counted_up(7));
    file.set("/rate", {}, std::vector<double>{200});
    file.set("/bytes", {9}, std::vector<std::uint16_t>(9, 65535), {}, H5T_STD_U16BE);
    file.attribute("/synced/gyro", "units", "rad/s");
    file.attribute("/synced/time", "units", "s", true);
  }
  const auto recording = log::open_recording(path);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->format(), "HDF5");
  EXPECT_EQ(info(*recording, "synced").count, 5000);
  EXPECT_EQ(field(*recording, "synced", "gyro[1]").unit, "rad/s");
  EXPECT_EQ(field(*recording, "synced", "time").unit, "s");
  const log::Rows rows = read(*recording, "synced", {"gyro[1]", "time", "turned[2]", "gyro[0]", "big"});
  for (std::size_t i = 0; i < kRows; ++i) {
    ASSERT_EQ(rows.columns[0][i], static_cast<double>(3 * i + 1));
    ASSERT_EQ(rows.columns[1][i], static_cast<double>(i));
    ASSERT_EQ(rows.columns[2][i], static_cast<double>(2 * kRows + i));
    ASSERT_EQ(rows.columns[3][i], static_cast<double>(3 * i));
  }
  expect_note(rows.notes, "big: whole numbers beyond 2^53 are rounded");
  EXPECT_THAT(read(*recording, "bytes", {"bytes"}).columns[0], testing::Each(65535));
  EXPECT_THAT(read(*recording, "synced.few", {"few"}).columns[0], testing::SizeIs(7));
  expect_note(recording->notes(), "3 x 5000 is taken as 5000 rows of 3: synced.turned");
  expect_note(recording->notes(), "rate = 200");
}

TEST_F(Hdf5, AsMatlabHasIt) {
  for (const bool nul_padded : {false, true}) {  // as MATLAB ends texts, and as h5py does
    const std::string path = this->path("log.mat");
    {
      Writer file(path, 512);
      file.group("/imu"), file.group("/#refs#");
      file.attribute("/imu", "MATLAB_class", "struct", nul_padded);
      file.set("/imu/wb", {3, 4}, std::vector<double>{1, 2, 3, 4, 11, 12, 13, 14, 21, 22, 23, 24});
      file.set("/imu/square", {2, 2}, std::vector<double>{1, 2, 3, 4});
      file.set("/imu/freq", {1, 1}, std::vector<double>{66.894});
      file.set("/#refs#/a", {5}, counted_up(5));
      file.set("/TT", {6, 1}, std::vector<std::uint16_t>(6, 1));
      file.attribute("/TT", "MATLAB_class", "timetable", nul_padded);
      file.attribute("/TT", "MATLAB_object_decode", "3");
      file.set("/note", {1, 4}, std::vector<std::uint16_t>(4, 'x'));
      file.attribute("/note", "MATLAB_class", "char", nul_padded);
      file.set("/none", {2}, std::vector<double>{0, 3});
      file.attribute("/none", "MATLAB_empty", "1");
    }
    std::string bytes = content(path);
    const std::string head = "MATLAB 7.3 MAT-file, written by a test" + std::string(116 - 38, ' ') +
                             std::string(8, '\0') + std::string("\0\x02IM", 4);
    bytes.replace(0, head.size(), head);
    const auto recording = open(bytes);
    EXPECT_EQ(recording->format(), "MATLAB 7.3");
    EXPECT_EQ(log::recorded_format(std::string_view(bytes).substr(0, 512)), "MATLAB 7.3");
    EXPECT_EQ(recording->streams().size(), 2U);
    EXPECT_THAT(read(*recording, "imu", {"wb[1]"}).columns[0], testing::ElementsAre(11, 12, 13, 14));
    EXPECT_THAT(read(*recording, "imu.square", {"square[0]"}).columns[0],
                testing::ElementsAre(1, 2));  // MATLAB's first column
    const auto& notes = recording->notes();
    expect_note(notes, "TT: of MATLAB's class timetable");
    expect_note(notes, "left out, text: note");
    expect_note(notes, "left out, empty: none");
    expect_note(notes, "imu.freq = 66.894");
  }
}

TEST_F(Hdf5, AsOctaveHasIt) {
  const std::string path = this->path("log.h5");
  {
    Writer file(path);
    file.group("/gyro"), file.group("/t");
    file.set("/gyro/value", {3, 4}, std::vector<double>{1, 2, 3, 4, 11, 12, 13, 14, 21, 22, 23, 24});
    file.set("/t/value", {1, 4}, counted_up(4));
    file.attribute("/gyro", "OCTAVE_NEW_FORMAT", "1"), file.attribute("/t", "OCTAVE_NEW_FORMAT", "1");
  }
  const log::Rows rows = read(*log::open_recording(path), "arrays", {"gyro[2]", "t"});
  EXPECT_THAT(rows.columns[0], testing::ElementsAre(21, 22, 23, 24));
  EXPECT_THAT(rows.columns[1], testing::ElementsAre(0, 1, 2, 3));
}

TEST_F(Hdf5, LinksCirclesAndWhatWasNeverFilled) {
  const std::string path = this->path("log.h5");
  {
    Writer file(path);
    file.group("/a");
    H5Lcreate_hard(file.id(), "/a", file.id(), "/a/again", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_external("/etc/other.h5", "/", file.id(), "/elsewhere", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_soft("/a/x", file.id(), "/soft", H5P_DEFAULT, H5P_DEFAULT);
    file.set("/a/x", {4}, counted_up(4));
    file.set("/huge", {hsize_t{1} << 39}, std::vector<double>{}, {1024});
  }
  const auto recording = log::open_recording(path);
  EXPECT_EQ(recording->streams().size(), 1U);
  expect_note(recording->notes(), "left out, links to elsewhere: elsewhere and soft");
  expect_note(recording->notes(), "left out, never filled: huge");
}

TEST_F(Hdf5, FiltersThatAreNotHereAreNamed) {
  constexpr H5Z_filter_t kFilter = 300;
  const auto pass = [](unsigned, std::size_t, const unsigned*, std::size_t bytes, std::size_t*, void**) {
    return bytes;
  };
  const H5Z_class2_t filter{H5Z_CLASS_T_VERS, kFilter, 1, 1, "of a stranger", nullptr, nullptr, pass};
  const std::string path = this->path("log.h5");
  {
    Writer file(path);
    H5Zregister(&filter);
    const hsize_t rows = 4;
    const hid_t space = H5Screate_simple(1, &rows, nullptr), creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(creation, 1, &rows);
    H5Pset_filter(creation, kFilter, 0, 0, nullptr);
    const hid_t data = H5Dcreate2(file.id(), "/x", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, counted_up(4).data());
    H5Dclose(data), H5Pclose(creation), H5Sclose(space);
  }
  EXPECT_EQ(log::open_recording(path)->streams().size(), 1U);
  H5Zunregister(kFilter);
  const auto without = log::open_recording(path);
  EXPECT_TRUE(without->streams().empty());
  expect_note(without->notes(), "left out, packed by the filter 300 (of a stranger), which is not here");
}

TEST_F(Hdf5, MemoryIsThatOfTheNumbers) {
  const std::string path = this->path("log.h5");
  {
    Writer file(path);
    constexpr hsize_t kRows = 2'000'000;
    file.set("/w", {kRows, 3}, counted_up(3 * kRows), {16384, 3});
    file.set("/t", {kRows}, counted_up(kRows));
  }
  expect_little_memory(path, "arrays");
}

TEST_F(Hdf5, CutIsAnError) {
  const std::string path = this->path("log.h5");
  {
    Writer file(path);
    file.set("/x", {4000}, counted_up(4000));
  }
  const std::string bytes = content(path);
  EXPECT_CONTAINS(refusal(bytes.substr(0, bytes.size() / 2)), "cannot be opened as HDF5: it is cut or damaged");
  cut_everywhere(bytes);
}

TEST_F(Hdf5, RealMatlab) {
  for (const char* name : {"mat/imu_struct_v73.mat", "mat/imu_struct_v73_h5py_strings.mat"}) {
    const std::string path = real(name);
    SKIP_WITHOUT(path);
    const log::Rows rows =
        read(*log::open_recording(path), "imu", {"wb[0]", "wb[1]", "wb[2]", "fb[0]", "fb[1]", "fb[2]"});
    EXPECT_NEAR(rows.columns[0][1], -0.01456970506, 5e-12);
    expect_statistics(rows, {0.301787157, 0.263545729, -0.105215530, -0.518938411, 1.81944909, 2.38339583},
                      {2.89680, 6.66490, 1.66369, 6.68042, 5.34805, 7.59485});
  }
  const auto objects = log::open_recording(real("mat/mcos_time_v73.mat"));
  EXPECT_TRUE(objects->streams().empty());
  expect_note(objects->notes(), "of MATLAB's class datetime");
  const auto types = log::open_recording(real("mat/types_le_hdf5.mat"));
  EXPECT_THAT(read(*types, "arrays", {"d[0]"}).columns[0], testing::ElementsAre(1, 6, 11, 16, 21, 26, 31, 36, 41, 46));
}

#else

TEST_F(Hdf5, WithoutTheLibraryItsPackageIsNamed) {
  EXPECT_CONTAINS(refusal("\x89HDF\r\n\x1a\n" + std::string(600, 'x')), "Debian's package libhdf5-dev");
}

#endif

}  // namespace
}  // namespace gyrobudget::app_tests
