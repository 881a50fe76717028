"""EtherCAT drives of the profile CiA 402 (CoE), by pysoem."""
