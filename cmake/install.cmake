# Install and find_package(majak): filled together with the package configuration.
