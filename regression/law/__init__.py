"""Compliances of throws within the law's range, fitted to thousands of finite-element results."""
