if(TARGET mv_core)
  find_package(VTK REQUIRED COMPONENTS CommonCore CommonDataModel IOXML)
  mv_add_test(unit_core
    SOURCES unit/core/config_test.cpp unit/core/units_test.cpp unit/core/case_files_test.cpp unit/core/damaged_files_test.cpp
            unit/core/atomic_file_test.cpp unit/core/csv_table_test.cpp unit/core/sha256_test.cpp
    LIBRARIES mv_core VTK::CommonCore VTK::CommonDataModel VTK::IOXML)
endif()
