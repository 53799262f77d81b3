// SPDX-License-Identifier: MIT
// Readers of recordings, on seeds written here byte by byte.
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/log/recording.h"
#include "gyrobudget/app/text/error.h"

#include "entries.h"

#if GYROBUDGET_HAS_HDF5
#include <hdf5.h>
#endif

#include <cmath>
#include <cstdint>
#include <numeric>
#include <stdexcept>

#include "../app/log/recording_writer.h"
#include "../app/packing.h"
#include "memory_file.h"

namespace gyrobudget::fuzz {
namespace {

using app_tests::deflated;
using U8 = std::uint8_t;
using U16 = std::uint16_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;

void check(const log::Recording& recording, std::size_t stream) {
  const log::StreamInfo& info = recording.streams()[stream];
  std::vector<std::size_t> fields(info.fields.size());
  std::iota(fields.begin(), fields.end(), std::size_t{0});
  log::Rows rows;
  try {
    rows = recording.read(stream, fields);
  } catch (const text::InputError&) {
    return;
  }
  promise(info.count >= 0, "a count below 0");
  promise(rows.columns.size() == fields.size(), "not the columns that were asked for");
  promise(info.clock.empty() == rows.stamps_ns.empty() || rows.stamps_ns.size() <= static_cast<std::size_t>(info.count),
          "stamps without a clock");
  for (const auto& column : rows.columns) {
    promise(column.size() <= static_cast<std::size_t>(info.count), "more rows than were counted");
    promise(info.clock.empty() || column.size() == rows.stamps_ns.size(), "a column of another length than the stamps");
    for (const double v : column) promise(!std::isinf(v), "an infinite number");
  }
}

/// Any recording: what a mutant is recognised as is its own affair.
void read_recording(std::string_view bytes) {
  const MemoryFile file(bytes);
  try {
    const auto recording = log::open_recording(file.path());
    if (!recording) return;
    for (std::size_t i = 0; i < recording->streams().size(); ++i) check(*recording, i);
  } catch (const text::InputError& error) {
    promise(error.what()[0] != '\0', "an error without a message");
  }
}

template <class... Numbers>
std::string packed(Numbers... numbers) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
  return bytes;
}

std::string padded(std::string text, std::size_t size) {
  text.resize(size, '\0');
  return text;
}

std::string ulog() {
  const auto message = [](char type, const std::string& content) {
    return packed(static_cast<U16>(content.size())) + type + content;
  };
  std::string bytes = "\x55\x4c\x6f\x67\x01\x12\x35\x01" + packed(U64{1});
  bytes += message('B', packed(U64{0}, U64{1}, U64{420}, U64{0}, U64{0}));
  bytes += message(
      'F',
      "sensor_gyro_fifo:uint64_t timestamp;float dt;float scale;uint8_t samples;int16_t[2] x;int16_t[2] y;int16_t[2] z;");
  bytes += message('F', "sensor_combined:uint64_t timestamp;inner[2] gyro_rad;uint32_t gyro_integral_dt;") +
           message('F', "inner:float a;");
  bytes += message('A', packed(U8{0}) + packed(U16{1}) + std::string("sensor_combined")) +
           message('A', packed(U8{1}) + packed(U16{2}) + std::string("sensor_gyro_fifo"));
  for (int i = 0; i < 4; ++i) {
    bytes += message('D', packed(U16{1}) + packed(U64(4000 * i)) + packed(1.F, 2.F, U32{4000}));
    bytes += message(
        'D', packed(U16{2}) + packed(U64(4000 * i)) + packed(250.F, .5F) + packed(U8{2}) + std::string(12, '\1'));
    bytes += message('O', packed(U16{3})) + message('S', "\x2f\x73\x13\x20\x25\x0c\xbb\x12");
  }
  return bytes;
}

std::string dataflash() {
  const auto message = [](U8 type, const std::string& body) {
    return "\xa3\x95" + std::string(1, static_cast<char>(type)) + body;
  };
  const auto format = [&](U8 type, U8 length, const char* name, const char* letters, const char* labels) {
    return message(0x80, packed(type, length) + padded(name, 4) + padded(letters, 16) + padded(labels, 64));
  };
  std::string bytes = format(0x80, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
  bytes += format(1, 3 + 8 + 1 + 8 + 2, "IMU", "QBffc", "TimeUS,I,GyrX,AccX,T");
  bytes += format(2, 31, "ISBH", "QHBBHHQf", "TimeUS,N,type,instance,mul,smp_cnt,SampleUS,smp_rate");
  bytes += format(3, 207, "ISBD", "QHHaaa", "TimeUS,N,seqno,x,y,z");
  bytes += format(4, 3 + 1 + 32, "FMTU", "BNN", "FmtType,UnitIds,MultIds") +
           message(4, packed(U8{1}) + padded("s#EoO", 16) + padded("F-00B", 16));
  bytes += format(5, 3 + 1 + 64, "UNIT", "bZ", "Id,Label") + message(5, "E" + padded("rad/s", 64));
  for (int i = 0; i < 3; ++i)
    bytes += message(1, packed(U64(1000 * i)) + packed(U8(i % 2)) + packed(1.F, 2.F) + packed(U16{3}));
  bytes += message(
      2, packed(U64{1}, U16{7}) + packed(U8{1}, U8{0}) + packed(U16{10}, U16{32}) + packed(U64{1}) + packed(1000.F));
  return bytes + message(3, packed(U64{1}, U16{7}) + packed(U16{0}) + std::string(192, 'x'));
}

std::string mat(bool compress) {
  const auto element = [](U32 type, const std::string& data) {
    return packed(type, static_cast<U32>(data.size())) + padded(data, (data.size() + 7) / 8 * 8);
  };
  const auto array = [&](U32 class_type, int rows, const std::string& name, const std::string& data) {
    return element(14, element(6, packed(class_type, U32{0})) + element(5, packed(rows, 1)) + element(1, name) + data);
  };
  std::string numbers;
  for (int i = 0; i < 4; ++i) numbers += packed(1.5 * i);
  const std::string fields = array(6, 4, "", element(9, numbers)) + array(9, 4, "", element(2, "abcd"));
  std::string variable =
      array(2, 1, "imu", element(5, packed(8)) + element(1, padded("wb", 8) + padded("t", 8)) + fields);
  if (compress) {
    const std::string data = deflated(variable, 15);
    variable = packed(U32{15}, static_cast<U32>(data.size())) + data;
  }
  const std::string opaque =
      element(14, element(6, packed(U32{17}, U32{0})) + element(1, "TT") + element(1, "MCOS") + element(1, "table"));
  return padded("MATLAB 5.0 MAT-file", 124) + packed(U16{0x100}) + "IM" + opaque + variable;
}

std::string npy(const char* descr, const char* shape, std::size_t bytes) {
  std::string header = std::string("{'descr': '") + descr + "', 'fortran_order': True, 'shape': " + shape + ", }";
  header.resize(117, ' ');
  header += '\n';
  return "\x93NUMPY" + packed(U8{1}, U8{0}, U16{118}) + header + std::string(bytes, '@');
}

std::string npz() {
  std::string bytes, directory;
  for (const bool deflate : {false, true}) {
    const std::string content = npy(deflate ? "<f8" : ">i2", "(4, 3)", deflate ? 96 : 24),
                      name = deflate ? "w.npy" : "t.npy";
    const std::string data = deflate ? deflated(content, -15) : content;
    const U32 crc =
        static_cast<U32>(::crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size())));
    const std::string common = packed(U16{20}, U16{0}) + packed(U16(deflate ? 8 : 0)) +
                               packed(U32{0}, crc, static_cast<U32>(data.size()), static_cast<U32>(content.size())) +
                               packed(U16{5}, U16{0});
    directory +=
        "PK\x01\x02" + packed(U16{20}) + common + padded("", 10) + packed(static_cast<U32>(bytes.size())) + name;
    bytes += "PK\x03\x04" + common + name + data;
  }
  return bytes + directory + "PK\x05\x06" + packed(U16{0}, U16{0}, U16{2}, U16{2}) +
         packed(static_cast<U32>(directory.size()), static_cast<U32>(bytes.size())) + packed(U16{0});
}

/// A text of a dataflash, or what a mutant makes of it, as a log.
void read_packed_text(std::string_view bytes) {
  const MemoryFile file(bytes);
  try {
    const allan::Record record = log::read_log({.path = file.path(), .rate_hz = 100, .unit = "deg/s"});
    promise(!record.axes.empty(), "a record without axes");
  } catch (const std::invalid_argument&) {  // a choice among its streams is left to the user
  } catch (const text::InputError& error) {
    promise(error.what()[0] != '\0', "an error without a message");
  }
}

/// As the library writes it; without it, its mark.
std::vector<std::string> hdf5_seeds() {
#if GYROBUDGET_HAS_HDF5
  constexpr std::size_t kGrowth = 4096;
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, kGrowth, 0);  // in memory
  const hid_t file = H5Fcreate("seed", H5F_ACC_TRUNC, H5P_DEFAULT, access);
  const hsize_t shape[] = {40, 3}, chunk[] = {16, 3};
  const std::vector<double> values(120, 0.5);
  const hid_t space = H5Screate_simple(2, shape, nullptr), creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(creation, 2, chunk);
  H5Pset_deflate(creation, 4);
  const hid_t gyro = H5Dcreate2(file, "gyro", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
  H5Dwrite(gyro, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dclose(gyro), H5Pclose(creation), H5Sclose(space);
  H5Fflush(file, H5F_SCOPE_GLOBAL);
  std::string seed(static_cast<std::size_t>(H5Fget_file_image(file, nullptr, 0)), '\0');
  H5Fget_file_image(file, seed.data(), seed.size());
  H5Fclose(file), H5Pclose(access);
  return {seed};
#else
  return {"\x89HDF\r\n\x1a\n"};
#endif
}

}  // namespace

std::vector<Entry> recording_entries() {
  const std::string text =
      "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nFMT, 1, 9, IMU, QBffc, TimeUS,I,GyrX,AccX,T\n"
      "IMU, 1000, 0, 1.5, 2, 3\nIMU, 2000, 1, nan, 2, -3\nIMU, 3000, 0, 1e999, 2, 3\n";
  const int gzip = 15 + 16;
  std::vector<std::string> packed{deflated(ulog(), gzip), deflated(mat(true), gzip)};
  for (const char* how : {"bz2", "lz4", "zstd"}) packed.push_back(recording_writer::pack(how, ulog()));
  std::vector<std::string> packed_text{deflated(text, gzip)};
  for (const char* how : {"bz2", "lz4", "zstd"}) packed_text.push_back(recording_writer::pack(how, text));
  return {{"ulog", read_recording, {ulog()}},
          {"dataflash", read_recording, {dataflash(), text}},
          {"mat", read_recording, {mat(false), mat(true)}},
          {"npz", read_recording, {npz(), npy("<i4", "(2, 3)", 24)}},
          {"packed", read_recording, packed},
          {"packed_text", read_packed_text, packed_text, 500},
          {"hdf5", read_recording, hdf5_seeds(), 100}};
}

}  // namespace gyrobudget::fuzz
